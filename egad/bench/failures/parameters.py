"""Settings of the search for failures of a detector."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import Fraction, ParameterGroup, Parameters, PositiveFraction, Seed
from egad.bench.parameters import PLANNING_TIME, ContactRule, PlanningTime
from egad.detectors import DetectorConfig, check_gripper, knows_scene
from egad.errors import UserError
from egad.evalset import PrintCheck
from egad.evolution import EvolutionParameters
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import LabelParameters
from egad.grippers import Gripper
from egad.sim import FAST_ENGINES, FastEngine

Strategy = Literal["evolution", "screening", "mutation", "random"]


class FailureSearch(Parameters):
    """Search for objects that a detector fails to grasp although they can be grasped."""

    attempts: int = Field(6000, ge=1)
    """total number of simulated grasps, including those of the reference"""
    shards: int = Field(2, ge=1, le=1000)
    """independent searches that share the attempts, one job each"""
    strategy: Strategy = "evolution"
    """where objects come from: screening: the archive; random: random genomes; mutation: children
    of the archive; evolution: the archive, random genomes and children of failures, most of them
    from the source that yields the most failures"""
    approach: Literal["above", "any"] | None = None
    """above: grasps straight from above; any: from any direction; nothing: above if the input of
    the detector is a view from above, any otherwise"""
    depth_noise: float = Field(0.1, ge=0, le=10)
    """noise of the depth images, as in `trials.depth_noise`, pixels; with the approach `any`,
    everything above 0 is 0.1"""
    engines: tuple[FastEngine, ...] = Field(FAST_ENGINES, min_length=1)
    """physics engines; a failure must be one in all of them"""
    screen: int = Field(5, ge=1)
    """maximum number of attempts of the detector to decide whether to examine an object further"""
    choose: int = Field(8, ge=1)
    """drops used to choose the grasps of the reference"""
    confirm: int = Field(24, ge=1)
    """maximum number of fresh drops in each engine to confirm a failure"""
    explain: int = Field(6, ge=0)
    """failed drops at which the other proposals of the detector are also tried"""
    least_reference: PositiveFraction = Field(0.8, lt=1)
    """minimum success rate of the reference at a failure"""
    least_difference: Fraction = Field(0.5, lt=1)
    """minimum difference between the success rates of the reference and the detector at a
    failure"""
    confidence: PositiveFraction = Field(0.95, lt=1)
    """confidence of `least_reference` and `least_difference`, in each engine"""
    elites_per_cell: int = Field(3, ge=1)
    """failures that a cell keeps: the least similar ones"""


class FailureParameters(ParameterGroup):
    """The settings that a search for failures depends on; `labels` are those of the reference."""

    seed: Seed
    gripper: Gripper
    rescale: Rescale
    failures: FailureSearch
    planning_time: PlanningTime = PLANNING_TIME
    trials: ContactRule = ContactRule()
    material: Material
    bundle: Bundle
    print_check: PrintCheck
    labels: LabelParameters
    breeding: EvolutionParameters


def check_searchable(detector: DetectorConfig, gripper: Gripper) -> None:
    """Raise UserError if a detector knows where objects lie, or is for another kind of gripper."""
    if knows_scene(detector):
        raise UserError(
            f"the detector {detector.name} knows where objects lie, as the reference does; search "
            "for failures of a detector that has to see them"
        )
    check_gripper(detector.name, gripper)


class DetectorFailures(FailureParameters):
    """Search for failures of a grasp detector."""

    detector: DetectorConfig
