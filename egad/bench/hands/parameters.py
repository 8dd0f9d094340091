"""Settings of a comparison of hands."""

from pydantic import Field

from egad._util.parameters import Length, Parameters, Seed
from egad.bench.parameters import NAMED_ERRORS, PLANNING_TIME, Errors, PlanningTime
from egad.detectors import NoiseName
from egad.grippers import Gripper
from egad.sim import ENGINES, EngineName


class HandTrials(Parameters):
    """Attempts of hands at the same objects, whose size does not depend on the hands."""

    size: Length = 0.06
    """opening that evolved objects are scaled to, by `rescale`, the same for all hands, metres;
    meshes of your own keep their size"""
    engine: EngineName = ENGINES[0]
    """physics engine, as in `trials`"""
    drops: int = Field(6, ge=1)
    """drops of each object that hands are judged on"""
    search_drops: int = Field(8, ge=1)
    """other drops of it, on which the best grasps are searched for"""
    tries: int = Field(3, ge=1)
    """maximum number of grasps tried at each of these"""
    naive: int = Field(3, ge=1)
    """naive grasps at each drop that hands are judged on"""
    noise: NoiseName = "stereo"
    """noise of depth images, as in `clutter.noise`"""
    errors: Errors = NAMED_ERRORS["typical"]
    """errors of a real cell, as in `trials.errors`, the same for all hands"""


class HandParameters(Parameters):
    """The settings that attempts of hands depend on, besides the hands."""

    seed: Seed
    """seed of everything random"""
    hands: HandTrials
    """the attempts"""
    planning_time: PlanningTime = PLANNING_TIME


class ComparedHands(Parameters):
    """The settings that the workflow's comparison of hands reads."""

    seed: Seed
    """seed of everything random"""
    grippers: dict[str, Gripper]
    """hands by name"""
    planning_time: PlanningTime = PLANNING_TIME
