"""Where objects come from, and what is made of them."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad.settings.base import Name, Section

MOST_PRIMITIVES = 100_000  # their ids have five digits


class Dataset(Section):
    """A set of objects: evolved here, from an archive, meshes of somebody else, or random ones."""

    source: Literal["evolved", "archive", "meshes", "primitives"] = Field(
        description="`evolved` by this pipeline, from an `archive` that was evolved before, "
        "`meshes` read from a folder, or `primitives` joined at random"
    )
    archive: str | None = Field(
        None, description="file of the archive, or `released`: the one shipped (source: archive)"
    )
    folder: str | None = Field(None, description="folder of the meshes (source: meshes)")
    units: Literal["m", "mm", "cm", "inch"] | None = Field(
        None, description="unit of the coordinates in these meshes (source: meshes)"
    )
    pattern: str | None = Field(
        None,
        description="glob of the mesh files, relative to the folder; what its wildcards match "
        "names the objects; nothing: `*`, all in the folder itself (source: meshes)",
    )
    objects: int | None = Field(
        None,
        ge=1,
        le=MOST_PRIMITIVES,
        description="how many, each of 2 to 5 boxes, cylinders and spheres (source: primitives)",
    )

    @model_validator(mode="after")
    def _keys_belong_to_the_source(self) -> Self:
        needed = {
            "evolved": (),
            "archive": ("archive",),
            "meshes": ("folder", "units"),
            "primitives": ("objects",),
        }
        allowed = {**needed, "meshes": ("folder", "units", "pattern")}
        given = [name for name, value in self if name != "source" and value is not None]
        if any(name not in given for name in needed[self.source]):
            keys = " and ".join(f"`{name}`" for name in needed[self.source])
            raise ValueError(f"a dataset with source `{self.source}` needs {keys}")
        if extra := [name for name in given if name not in allowed[self.source]]:
            raise ValueError(f"a dataset with source `{self.source}` takes no `{extra[0]}`")
        return self


class Targets(Section):
    """What `snakemake --cores 2` makes when no file is named."""

    datasets: list[Name] = Field(
        ["egad"],
        description="datasets taken all the way: grasps, scaling, evaluation set, print, trials",
    )
    grippers: list[Name] = Field(
        ["egad_75mm"], min_length=1, description="grippers of the table below to do this for"
    )
    policies: list[Name] = Field(
        ["antipodal-depth"],
        min_length=1,
        description="grasp detectors of the table below to try in simulation",
    )
    exports: list[Literal["dexnet", "acronym", "jacquard", "cornell", "gqcnn"]] = Field(
        [],
        description="formats of other programs to write, too: the labelled grasps as dexnet or "
        "acronym, rendered images with them as jacquard, cornell or gqcnn",
    )
    agreement: bool = Field(
        False, description="whether to carry out a sample of the labelled grasps in simulation, too"
    )
    render: bool = Field(
        False, description="whether to render depth images with grasps, to train on, too"
    )
