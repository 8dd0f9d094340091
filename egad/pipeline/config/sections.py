"""Settings of the pipeline itself: datasets, targets, schedule, repair, training study."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    FractionRange,
    Length,
    Name,
    Parameters,
    PositiveFraction,
    ScaleRule,
    check_ascending,
)
from egad.geometry.parameters import SHELL_THICKNESS, SIDE_FRACTION, OpenSurfaces
from egad.pipeline.config.formats import Format


class Schedule(Parameters):
    """How evolution is cut into jobs. More epochs than before extend a finished run."""

    islands: int = Field(
        1, ge=1, le=1024, description="archives that evolve apart within an epoch, then merge"
    )
    epochs: int = Field(1, ge=1, le=200, description="rounds of evolving apart and merging")


class Postprocess(Parameters):
    """Repair, and difficulty graded again without the luck of selection."""

    grasps: int = Field(1000, ge=1, description="grasps that an object is graded by")
    min_volume: float = Field(1e-9, ge=0, description="objects smaller than this are rejected, m3")
    open_surfaces: OpenSurfaces = Field(
        "reject",
        description="what is done with surfaces that stay open when small holes are closed, such "
        "as scans of glasses and bowls: reject them, or thicken them to closed shells",
    )
    shell_thickness: Length = Field(
        SHELL_THICKNESS,
        description="wall of these shells, metres; the surface lies in its middle "
        "(open_surfaces: thicken)",
    )


class Rescale(Parameters):
    """Scaling to a gripper."""

    rule: ScaleRule = Field(
        "paper",
        description="paper: smallest side at most the fraction; egad-script: longest side = "
        "opening, then as paper; exact: smallest side = the fraction",
    )
    side_fraction: PositiveFraction = Field(
        SIDE_FRACTION, description="part of the opening that the rule aims at"
    )


MOST_PRIMITIVES = 100_000  # their ids have five digits


class Dataset(Parameters):
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


class Targets(Parameters):
    """What `snakemake --cores 2` makes when no file is named."""

    datasets: list[Name] = Field(
        ["egad"],
        description="datasets taken all the way: grasps, scaling, evaluation set, print, trials",
    )
    grippers: list[Name] = Field(
        ["egad_75mm"], min_length=1, description="grippers of the table below to do this for"
    )
    detectors: list[Name] = Field(
        ["antipodal-depth"],
        min_length=1,
        description="grasp detectors of the table below to try in simulation",
    )
    exports: list[Format] = Field(
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


WHOLE = (0.0, 1.0)


class TrainingSet(Parameters):
    """What a network learns from, or weights that somebody else trained."""

    dataset: Name | None = Field(None, description="dataset of the objects that are rendered")
    complexity: FractionRange = Field(
        WHOLE,
        description="which of them, by their rank in complexity: [0, 0.33] is the simplest third",
    )
    subset: PositiveFraction = Field(1.0, description="how many of these, drawn by chance")
    hold_out: bool = Field(
        True, description="whether the objects of its evaluation set are left out of the training"
    )
    weights: str | None = Field(
        None, description="file of given weights, in the place of all these: nothing is trained"
    )

    @model_validator(mode="after")
    def _either_objects_or_weights(self) -> Self:
        if (self.dataset is None) == (self.weights is None):
            raise ValueError("a training set needs either `dataset` or `weights`")
        if self.weights and (self.complexity != WHOLE or self.subset < 1 or not self.hold_out):
            raise ValueError(
                "a training set with `weights` takes no `complexity`, `subset` or `hold_out`"
            )
        check_ascending(self, "complexity")
        return self


TRAINING_SETS = {
    "evolved": TrainingSet(dataset="egad"),
    "third": TrainingSet(dataset="egad", subset=0.333),
    "simple": TrainingSet(dataset="egad", complexity=(0.0, 0.333)),
    "complex": TrainingSet(dataset="egad", complexity=(0.667, 1.0)),
}


class TrainingStudy(Parameters):
    """What the objects that a network learns from are worth; see docs/training-study.md."""

    sets: list[Name] = Field([], description="training sets of the table below to compare")
    seeds: int = Field(
        2, ge=1, le=100, description="networks trained on each; they differ in chance alone"
    )
    tests: list[Name] = Field(
        [], description="datasets whose evaluation sets the networks are tried on"
    )
    references: list[Name] = Field(
        [], description="grasp detectors of the table above that are shown beside the networks"
    )
