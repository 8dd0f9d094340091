"""The settings of a dataset: where its objects come from."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Parameters, UserPath

MAX_PRIMITIVES = 100_000  # their ids have five digits


class DatasetSection(Parameters):
    """A set of objects: evolved, from an archive, from mesh files, or random primitives."""

    source: Literal["evolved", "archive", "meshes", "primitives"]
    """`evolved`: by this pipeline; `archive`: from an existing archive; `meshes`: read from a
    folder; `primitives`: random unions of primitives"""
    archive: UserPath | None = None
    """archive file, or `released` for the one shipped with egad (source: archive)"""
    folder: UserPath | None = None
    """folder of the meshes (source: meshes)"""
    units: Literal["m", "mm", "cm", "inch"] | None = None
    """unit of the mesh coordinates, unless the files state it (source: meshes)"""
    pattern: str | None = None
    """glob of the mesh files, relative to the folder; objects are named after what its wildcards
    match; nothing: `*`, all files in the folder itself (source: meshes)"""
    evaluation_set: UserPath | None = None
    """objects of the evaluation set: `all`, under their own names (as `names` if all have such
    names); `cells`: one of each cell of the grid of `select_eval`; `names`: those named A0 to Z9;
    or a CSV file with the columns id and label (source: meshes); nothing: `all` for meshes, `cells`
    for others"""
    objects: int | None = Field(None, ge=1, le=MAX_PRIMITIVES)
    """number of objects, each made of 2 to 5 boxes, cylinders and spheres (source: primitives)"""

    @property
    def selection(self) -> str:
        """How the evaluation set is chosen: all, cells, names, or labels (of a file)."""
        chosen = self.evaluation_set or ("all" if self.source == "meshes" else "cells")
        return chosen if chosen in ("all", "cells", "names") else "labels"

    @model_validator(mode="after")
    def _keys_belong_to_the_source(self) -> Self:
        needed = {
            "evolved": (),
            "archive": ("archive",),
            "meshes": ("folder",),
            "primitives": ("objects",),
        }
        allowed = {**needed, "meshes": ("folder", "units", "pattern", "evaluation_set")}
        given = [name for name, value in self if name != "source" and value is not None]
        if any(name not in given for name in needed[self.source]):
            keys = " and ".join(f"`{name}`" for name in needed[self.source])
            raise ValueError(f"a dataset with source `{self.source}` needs {keys}")
        if extra := [name for name in given if name not in allowed[self.source]]:
            raise ValueError(f"a dataset with source `{self.source}` takes no `{extra[0]}`")
        return self
