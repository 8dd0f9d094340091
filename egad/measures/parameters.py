"""Settings of the measures and of the space that they span."""

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    Archived,
    Fraction,
    Length,
    Name,
    ParameterGroup,
    Parameters,
    Percent,
    Range,
    ScaleRule,
    Seed,
    SideFraction,
    UserPath,
    check_ascending,
    with_defaults,
)
from egad.geometry import SHELL_THICKNESS, Material, OpenSurfaces
from egad.grasps import Quality, Robust, Sampling
from egad.grippers import SUCTION, Gripper
from egad.measures.reeb import Similarity

MAX_CANDIDATES = 32768  # of the final estimate of graspability
MAP_RULE: ScaleRule = "exact"  # at this size the objects of the map are measured
BINS = 512  # of the histogram of angular deficits


class MeasureSpace(Parameters):
    """The two measures that span the space, and the archive of elites."""

    complexity_range: Range = (1.0, 5.0)
    """range of complexity that the cells cover"""
    graspability_range: Range = (0.0005, 0.004)
    """range of graspability (a grasp quality: high is easy) that the cells cover"""
    cells: int = Field(25, ge=1, le=26)
    """cells along each axis"""
    elites_per_cell: int = Field(4, ge=1, le=255)
    """slots per cell: maximum number of elites in it"""
    neighbors: int = Field(10, ge=1)
    """diversity is the mean distance to this many nearest objects"""
    confidence: Fraction = 0.99
    """the cell of an object is certain if its graspability lies in that cell with at least this
    probability; 0: always certain"""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        check_ascending(self, "complexity_range", "graspability_range")
        return self


AXES = ("complexity", "graspability")


class CustomMeasures(Parameters):
    """Your own measures as axes of the space, instead of complexity or graspability.

    `FILE.py:FUNCTION` or `package.module:FUNCTION` names a function that takes a closed
    `trimesh.Trimesh` in metres and returns a number.
    """

    # Any other key is a parameter of the measures whose function has an argument of that name.

    complexity: UserPath = ""
    """function that replaces complexity; empty: none"""
    graspability: UserPath = ""
    """function that replaces graspability, with high values in row A; empty: none"""

    @model_validator(mode="after")
    def _functions_are_named(self) -> Self:
        for key, text in self.functions().items():
            module, _, function = text.rpartition(":")
            if not (module and function.isidentifier()):
                raise ValueError(
                    f"{key} is {text!r}; allowed: FILE.py:FUNCTION or package.module:FUNCTION"
                )
        return self

    def functions(self) -> dict[str, str]:
        """The names of the functions, by axis."""
        return {axis: name for axis in AXES if (name := getattr(self, axis))}

    def parameters(self) -> dict[str, Any]:
        """The parameters of these functions."""
        return {key: value for key, value in self if key not in AXES}


class Complexity(Parameters):
    """The entropy of the angular deficits of the vertices."""

    bins: int = Field(BINS, ge=2)
    """histogram bins over [-2 pi, 2 pi)"""


class Graspability(Parameters):
    """A percentile of the quality of sampled grasps. High values are easy."""

    gripper: Name = "yumi"
    """gripper that grasps are sampled for, from the table of grippers"""
    metric: Literal["nominal", "robust"] = "nominal"
    """nominal: quality of the grasp itself; robust: mean quality over perturbed copies; the
    published letters follow the nominal quality (rank correlation 0.94 against 0.43,
    docs/measures.md)"""
    candidates: int = Field(512, ge=1)
    """initial number of candidate grasps; doubled until the cell is certain"""
    percentile: float = Field(75, ge=0, le=100)
    """percentile of the qualities, percent"""


class SizeEffect(Parameters):
    """How grasp quality changes with the size of an object."""

    fractions: list[SideFraction] = Field(
        [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2], min_length=1
    )
    """sizes to test: smallest side of the minimum-volume box / opening, ascending"""
    percentiles: list[Percent] = Field([65.0, 75.0, 85.0], min_length=1)
    """percentiles of the quality, ascending"""
    grasps: int = Field(200, ge=1)
    """grasps sampled at each size"""
    repeats: int = Field(5, ge=1)
    """repetitions with different random numbers"""

    @model_validator(mode="after")
    def _lists_ascend(self) -> Self:
        for name in ("fractions", "percentiles"):
            values = getattr(self, name)
            if any(low >= high for low, high in pairwise(values)):
                raise ValueError(f"{name} must ascend, got {', '.join(map(str, values))}")
        return self


# the rest does not change how grasps are sampled
HAND = Archived(keys=frozenset({"opening", "sampler", "cup"}))


class MeasureParameters(ParameterGroup):
    """The settings that the measures of an object depend on."""

    seed: Annotated[Seed, Archived(graspability=False)]
    gripper: Annotated[Gripper, HAND]
    measures: CustomMeasures
    complexity: Annotated[Complexity, Archived(graspability=False)]
    graspability: Graspability
    space: Annotated[MeasureSpace, Archived(graspability=False)]
    similarity: Annotated[Similarity, Archived(graspability=False)]
    sampling: Sampling
    quality: Quality
    robust: Robust | None  # of cups, or if the metric is robust: else its settings do not matter
    density: float = Material().density  # of the object, kg/m3, for suction cups


def space_of(gripper: Gripper, space: MeasureSpace) -> MeasureSpace:
    """The space; for a suction cup, a range that suits the share of 25 copies that hold."""
    jaws = MeasureSpace().graspability_range
    if gripper.grasps_with != SUCTION or space.graspability_range != jaws:
        return space
    return space.model_copy(update={"graspability_range": (0.02, 1.02)})


def default_measures(gripper: Gripper, seed: int) -> MeasureParameters:
    """The default parameters of EGAD's measures; `UserError` if the seed is not allowed."""
    space = space_of(gripper, MeasureSpace())
    return with_defaults(MeasureParameters, seed=seed, gripper=gripper, space=space, robust=None)


class SizeEffectParameters(ParameterGroup):
    """The settings that grasp quality over the size of objects depends on."""

    seed: int
    gripper: Gripper
    size_effect: SizeEffect
    sampling: Sampling
    quality: Quality
    robust: Robust | None = None  # of suction cups
    density: float = Material().density  # of the object, kg/m3, for suction cups


class Postprocess(Parameters):
    """Mesh repair, and measurement with other grasps than those used for selection in evolution."""

    max_candidates: int = Field(MAX_CANDIDATES, ge=1)
    """maximum number of candidate grasps per object; sampling stops earlier once the cell of the
    object is certain"""
    open_surfaces: OpenSurfaces = "reject"
    """treatment of surfaces that are still open after small holes are closed, such as scans of
    glasses and bowls: reject them, or thicken them to closed shells"""
    shell_thickness: Length = SHELL_THICKNESS
    """wall thickness of thickened surfaces, metres, half on each side of the surface
    (open_surfaces: thicken)"""


class MeasureMeshes(MeasureParameters):
    """Measures of repaired objects, and their mass."""

    postprocess: Postprocess
    material: Material


class GraspabilityOfGripper(MeasureParameters):
    """Measures of objects for one gripper."""

    postprocess: Postprocess


class CellsAndDiversities(ParameterGroup):
    """The cells of objects, and how much their shapes differ."""

    space: MeasureSpace
    similarity: Similarity
