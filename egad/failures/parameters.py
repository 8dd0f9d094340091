"""Settings of the search for failures of a detector."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import (
    Fraction,
    ParameterGroup,
    Parameters,
    PositiveFraction,
    Seed,
)
from egad.detectors import DetectorConfig, check_gripper
from egad.errors import UserError
from egad.evalset import Bundle, PrintCheck
from egad.geometry import Material, Rescale
from egad.grasps import LabelParameters
from egad.grippers import Gripper
from egad.map_elites import EvolutionParameters
from egad.sim import ENGINES, EngineName

Strategy = Literal["evolution", "screening", "mutation", "random"]


class FailureSearch(Parameters):
    """Search for objects at which a detector fails although they can be grasped."""

    attempts: int = Field(
        6000, ge=1, description="simulated grasps in all, those of the reference included"
    )
    shards: int = Field(
        2, ge=1, le=1000, description="independent searches that share the attempts, one job each"
    )
    strategy: Strategy = Field(
        "evolution",
        description="where objects come from: screening: the archive; random: random genomes; "
        "mutation: children of the archive; evolution: the archive, random genomes and children of "
        "failures, most from the one that gives most failures",
    )
    approach: Literal["above", "any"] | None = Field(
        None,
        description="grasps straight from above, or from any direction; nothing: what the input of "
        "the detector says: a view from above or something else",
    )
    depth_noise: float = Field(
        0.1, ge=0, le=10, description="noise of the depth images, as `trials.depth_noise`, pixels"
    )
    engines: tuple[EngineName, ...] = Field(
        ENGINES,
        min_length=1,
        description="physics engines, in all of which an object must be a failure",
    )
    screen: int = Field(
        5, ge=1, description="most attempts of the detector that decide whether to look further"
    )
    choose: int = Field(
        8, ge=1, description="drops on which the grasps of the reference are chosen"
    )
    confirm: int = Field(
        24, ge=1, description="most fresh drops in each engine that confirm a failure"
    )
    explain: int = Field(
        6, ge=0, description="drops at which the other proposals of the detector are tried, too"
    )
    least_reference: PositiveFraction = Field(
        0.8, lt=1, description="success rate of the reference at a failure, at least"
    )
    least_regret: Fraction = Field(
        0.5,
        lt=1,
        description="success rate of the reference minus that of the detector, at least",
    )
    confidence: PositiveFraction = Field(
        0.95, lt=1, description="confidence of both, in each engine"
    )
    elites_per_cell: int = Field(
        3, ge=1, description="failures that a cell keeps: those that are least alike"
    )
    planning_time: float = Field(
        60.0, gt=0, description="time limit of the detector, seconds; what exceeds it fails"
    )


class FailureParameters(ParameterGroup):
    """The settings that a search for failures depends on.

    Attributes:
        seed: Decides all that is random.
        gripper: What objects are scaled to and grasped with.
        rescale: How they are scaled.
        failures: The search.
        material: Of the objects.
        bundle: Their convex parts in the simulation.
        print_check: A failure can be printed.
        labels: Grasps that the reference begins with.
        breeding: How genomes are bred and measured, and the cells.
    """

    seed: Seed
    gripper: Gripper
    rescale: Rescale
    failures: FailureSearch
    material: Material
    bundle: Bundle
    print_check: PrintCheck
    labels: LabelParameters
    breeding: EvolutionParameters


def check_searchable(detector: DetectorConfig, gripper: Gripper) -> None:
    """Make sure that failures of a detector can be searched for.

    Raises:
        UserError: It is for another kind of gripper, or knows where objects lie.
    """
    if detector.detector == "labels":
        raise UserError(
            "labels knows where objects lie, as the reference does: failures are those of a "
            "detector that has to see them"
        )
    check_gripper(detector.name, gripper)
