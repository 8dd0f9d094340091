"""Settings of the pipeline itself: datasets, targets, schedule, repair, release."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, Length, Name, Parameters, UserPath
from egad.exchange import EVALUATION_SET, Format, ObjectFormat, ObjectSet
from egad.geometry import SHELL_THICKNESS, OpenSurfaces
from egad.measures import MAX_CANDIDATES


class Schedule(Parameters):
    """How evolution is divided into jobs. A higher number of epochs extends a finished run."""

    islands: int = Field(
        1,
        ge=1,
        le=1024,
        description="archives that evolve independently within an epoch and are then merged",
    )
    epochs: int = Field(1, ge=1, le=200, description="rounds of independent evolution and merging")


class Postprocess(Parameters):
    """Mesh repair, and measurement with other grasps than those used for selection in evolution."""

    max_candidates: int = Field(
        MAX_CANDIDATES,
        ge=1,
        description="maximum number of candidate grasps per object; sampling stops earlier once "
        "the cell of the object is certain",
    )
    min_volume: float = Field(
        1e-9, ge=0, description="objects with a smaller volume are rejected, m3"
    )
    open_surfaces: OpenSurfaces = Field(
        "reject",
        description="treatment of surfaces that are still open after small holes are closed, such "
        "as scans of glasses and bowls: reject them, or thicken them to closed shells",
    )
    shell_thickness: Length = Field(
        SHELL_THICKNESS,
        description="wall thickness of thickened surfaces, metres, half on each side of the "
        "surface (open_surfaces: thicken)",
    )


MAX_PRIMITIVES = 100_000  # their ids have five digits


class DatasetSection(Parameters):
    """A set of objects: evolved, from an archive, from mesh files, or random primitives."""

    source: Literal["evolved", "archive", "meshes", "primitives"] = Field(
        description="`evolved`: by this pipeline; `archive`: from an existing archive; `meshes`: "
        "read from a folder; `primitives`: random unions of primitives"
    )
    archive: UserPath | None = Field(
        None,
        description="archive file, or `released` for the one shipped with egad (source: archive)",
    )
    folder: UserPath | None = Field(None, description="folder of the meshes (source: meshes)")
    units: Literal["m", "mm", "cm", "inch"] | None = Field(
        None,
        description="unit of the mesh coordinates, unless the files state it (source: meshes)",
    )
    pattern: str | None = Field(
        None,
        description="glob of the mesh files, relative to the folder; objects are named after what "
        "its wildcards match; nothing: `*`, all files in the folder itself (source: meshes)",
    )
    evaluation_set: UserPath | None = Field(
        None,
        description="objects of the evaluation set: `all`, under their own names (as `names` if "
        "all have such names); `cells`: one of each cell of the grid of `select_eval`; `names`: "
        "those named A0 to Z9; or a CSV file with the columns id and label (source: meshes); "
        "nothing: `all` for meshes, `cells` for others",
    )
    objects: int | None = Field(
        None,
        ge=1,
        le=MAX_PRIMITIVES,
        description="number of objects, each made of 2 to 5 boxes, cylinders and spheres (source: "
        "primitives)",
    )

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


class Targets(Parameters):
    """What `snakemake --cores 2` makes if no file is named."""

    datasets: list[Name] = Field(
        ["egad"],
        description="datasets that run through the whole pipeline: grasps, scaling, evaluation "
        "set, prints, trials",
    )
    grippers: list[Name] = Field(
        ["egad_75mm"],
        min_length=1,
        description="grippers to make results for, from the table `grippers`",
    )
    detectors: list[Name] = Field(
        ["antipodal-depth"],
        min_length=1,
        description="grasp detectors to test in simulated trials, from the table `detectors`",
    )
    clutter: list[Name] = Field(
        [],
        description="grasp detectors to test on clearing tables with several objects, from the "
        "table `detectors`",
    )
    failures: list[Name] = Field(
        [],
        description="grasp detectors whose failures to search for, from the table `detectors`; a "
        "failure is an object of the datasets, or a child of one, that can be grasped but that the "
        "detector does not grasp",
    )
    exports: list[Format] = Field(
        [],
        description="formats to export for other programs: objects, labelled grasps, or rendered "
        "images with grasps",
    )
    export_objects: ObjectSet = Field(
        EVALUATION_SET, description="which objects to export, in formats for objects"
    )
    graspability: bool = Field(
        False, description="whether to measure the graspability of all objects for each gripper"
    )
    agreement: bool = Field(
        False, description="whether to execute a sample of the labelled grasps in simulation"
    )
    simulated_labels: bool = Field(
        False,
        description="whether to simulate labelled grasps of all objects; always done if `exports` "
        "has acronym, graspgen, graspnet, isaac_grasp or simready",
    )
    render: bool = Field(
        False, description="whether to render depth images with grasps for training"
    )
    scenes: bool = Field(
        False,
        description="whether to make packed and piled scenes with depth images and grasps labelled "
        "by simulation, for training",
    )


class Release(Parameters):
    """The folder `results/release`, a dataset that anyone can host: docs/released.md."""

    dataset: Name = Field("egad", description="dataset whose objects are released")
    gripper: Name = Field(
        "panda",
        description="gripper that the objects are scaled to and the grasps are for, from the table "
        "`grippers`",
    )
    grasps: int = Field(
        100,
        ge=1,
        description="maximum number of grasps per object; only grasps with a simulated label are "
        "released, at most `simulated_label.grasps`",
    )
    validation: Fraction = Field(
        0.15,
        lt=1,
        description="maximum fraction of the objects outside the test split to use for validation; "
        "families are kept together",
    )
    archives: list[ObjectFormat] = Field(
        ["urdf", "mjcf"],
        description="formats of the object archives for simulators; usd needs `pip install "
        "'egad[usd]'`",
    )
    title: str = Field(
        "EGAD: evolved objects for robot grasping", description="human-readable name of the dataset"
    )
    version: str = Field("1.0.0", description="version of the dataset, stated in its card")
    date: str | None = Field(
        None,
        pattern=r"^\d{4}-\d{2}-\d{2}$",
        description="date of publication, YYYY-MM-DD, stated in its card",
    )
    url: str | None = Field(
        None,
        description="address of the folder where it is hosted, or of the dataset on Hugging Face; "
        "stated in its card",
    )
