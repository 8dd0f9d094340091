"""Settings of a comparison of hands."""

from pydantic import Field

from egad._util.parameters import Length, Parameters, Seed
from egad.bench.parameters import NAMED_ERRORS, PLANNING_TIME, Errors, PlanningTime
from egad.detectors import NoiseName
from egad.grippers import Gripper
from egad.sim import ENGINES, EngineName


class HandTrials(Parameters):
    """Attempts of hands at the same objects, whose size does not depend on the hands."""

    size: Length = Field(
        0.06,
        description="opening that evolved objects are scaled to, by `rescale`, the same for all "
        "hands, metres; meshes of your own keep their size",
    )
    engine: EngineName = Field(ENGINES[0], description="physics engine, as in `trials`")
    drops: int = Field(6, ge=1, description="drops of each object that hands are judged on")
    search_drops: int = Field(
        8, ge=1, description="other drops of it, on which the best grasps are searched for"
    )
    tries: int = Field(3, ge=1, description="maximum number of grasps tried at each of these")
    naive: int = Field(3, ge=1, description="naive grasps at each drop that hands are judged on")
    noise: NoiseName = Field("stereo", description="noise of depth images, as in `clutter.noise`")
    errors: Errors = Field(
        NAMED_ERRORS["typical"],
        description="errors of a real cell, as in `trials.errors`, the same for all hands",
    )


class HandParameters(Parameters):
    """The settings that attempts of hands depend on, besides the hands."""

    seed: Seed = Field(description="seed of everything random")
    hands: HandTrials = Field(description="the attempts")
    planning_time: PlanningTime = PLANNING_TIME


class ComparedHands(Parameters):
    """The settings that the workflow's comparison of hands reads."""

    seed: Seed = Field(description="seed of everything random")
    grippers: dict[str, Gripper] = Field(description="hands by name")
    planning_time: PlanningTime = PLANNING_TIME
