"""Settings of trials with detectors, of cleared tables, and of naive grasps."""

from functools import partial
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from egad._util.parameters import (
    SCALE_RULES,
    Length,
    ParameterGroup,
    Parameters,
    Pixels,
    Range,
    Seed,
    UserParameters,
    by_name,
)
from egad.bench.protocols import NAMED_PROTOCOLS, SCENE_KINDS, Protocol, SceneKind
from egad.detectors import DetectorConfig, NoiseName
from egad.errors import check_name
from egad.geometry import Material
from egad.grasps import Quality
from egad.grippers import Gripper, as_gripper
from egad.sim import (
    COLLISION_FORCE,
    ENGINES,
    EngineName,
    Lifting,
    SimulatedLabel,
    check_engine,
    contacts_in_words,
)

Offset = Annotated[float, Field(ge=0, le=0.1)]
PLANNING_TIME = 60.0
PlanningTime = Annotated[
    float,
    Field(gt=0, description="time limit of a detector, seconds; an attempt that exceeds it fails"),
]


class CellErrors(UserParameters):
    """Errors of a real cell: none, typical (docs/trials.md), or a section of your own.

    Values are standard deviations of normal distributions; factors are uniform within ranges.
    """

    calibration: Offset = 0.0
    """error of the calibrated camera position along each axis, metres; sampled once for 20 attempts
    at an object, or for a round"""
    calibration_turn: float = Field(0.0, ge=0, le=10)
    """error of the calibrated camera rotation about each axis through the middle of the table,
    where it was calibrated, degrees; sampled together with `calibration`"""
    positioning: Offset = 0.0
    """error of the hand's position along each axis, metres; sampled per attempt"""
    opening: Offset = 0.0
    """error of the hand's opening before it closes, metres; sampled per attempt"""
    friction: Range = (1.0, 1.0)
    """range of the factor on the friction of the pads; sampled per attempt"""
    mass: Range = (1.0, 1.0)
    """range of the factor on the mass of an object; sampled per attempt"""
    stopping_force: Range = (1.0, 1.0)
    """range of the factor on the force that stops the hand; sampled per attempt"""

    def __str__(self) -> str:
        """The name of these errors, or their values."""
        names = [name for name, errors in NAMED_ERRORS.items() if errors == self]
        return names[0] if names else super().__str__()

    @model_validator(mode="after")
    def _factors_can_be_drawn(self) -> Self:
        for name in ("friction", "mass", "stopping_force"):
            low, high = getattr(self, name)
            if not 0 < low <= high:
                raise ValueError(f"{name} must go from a positive low to high, got {low} to {high}")
        return self


NAMED_ERRORS: dict[str, CellErrors] = {
    "none": CellErrors(),
    "typical": CellErrors(
        calibration=0.0025,
        calibration_turn=0.5,
        positioning=0.001,
        opening=0.0005,
        friction=(0.75, 1.25),
        mass=(0.9, 1.1),
        stopping_force=(0.8, 1.2),
    ),
}


Errors = Annotated[CellErrors, BeforeValidator(partial(by_name, "errors", NAMED_ERRORS))]


class ContactRule(Parameters):
    """What a contact of the hand on its way down means."""

    contact: Literal["collided", "close"] = Field(
        "collided",
        description="what a contact on the way down means: "
        f"{contacts_in_words('collided', 'close')}, as on the robot of EGAD",
    )
    stopping_force: float = Field(COLLISION_FORCE, gt=0, le=1000)
    """contact force that stops the hand on its way down, newtons; the robot of EGAD closed its
    fingers at 10 and gave up at 20"""


class TrialProtocol(ContactRule, Lifting):
    """Attempts to grasp single objects in simulation."""

    attempts: int = Field(10, ge=1)
    """attempts per object; half of those in the paper, to end sooner"""
    reset: Literal["continue", "redrop"] = "continue"
    """continue: after a success the hand tilts and drops the object, after a failure the object
    stays where it is, as with a real robot; redrop: every attempt starts with a drop in a random
    orientation, the same for all detectors"""
    image: tuple[Pixels, Pixels] = (640, 480)
    """width and height of the depth image, pixels"""
    field_of_view: float = Field(75.0, gt=1, lt=170)
    """horizontal field of view of the camera, degrees"""
    camera_height: Length = 0.6
    """height of the camera above the table, metres"""
    depth_noise: float = Field(0.0, ge=0, le=10)
    """standard deviation of the disparity, as in a stereo camera, pixels; about 0.1 for a D435; if
    not 0, the image also has holes beside edges and on steep surfaces"""
    errors: Errors = NAMED_ERRORS["none"]
    """errors of a real cell: none, typical, or a section of your own"""


class Clutter(Parameters):
    """Rounds of clearing a table of several objects."""

    engine: EngineName = ENGINES[0]
    """physics engine, as in `trials`"""
    scenes: tuple[SceneKind, ...] = Field(SCENE_KINDS, min_length=1)
    """kinds of scenes: single: one object, dropped; packed: objects upright side by side; pile:
    objects dropped on top of each other"""
    protocol: Protocol = NAMED_PROTOCOLS["egad"]
    """rules of a published benchmark (egad, vgn, giga, edgegrasp), or a section of your own"""
    noise: tuple[NoiseName, ...] | None = Field(None, min_length=1)
    """kinds of noise added to depth images: none; stereo: as with `trials.depth_noise` of 0.1
    pixels; gamma: as in Dex-Net 2.0 and the later code of VGN; dex: as in GIGA; points: 0.8 mm on
    the points of the cloud only, as in EdgeGrasp; nothing: those of the protocol"""
    rounds: int = Field(100, ge=1)
    """rounds for each kind of scene and noise"""
    objects: int = Field(5, ge=1, le=20)
    """objects in packed and piled scenes"""
    errors: Errors = NAMED_ERRORS["none"]
    """errors of a real cell, as in `trials.errors`"""

    @property
    def noises(self) -> tuple[NoiseName, ...]:
        """The kinds of noise: those given, or else those of the protocol."""
        return self.noise or self.protocol.noise


def hand_of(gripper: Gripper | str, rule: str, engine: str) -> Gripper:
    """The gripper of a run; UserError without such a gripper, scale rule or installed engine."""
    hand = as_gripper(gripper)
    check_name("rule", rule, SCALE_RULES)
    check_engine(engine)
    return hand


class NaiveGrasp(Parameters):
    """Naive grasps, whose simulated success rate says how forgiving an object is.

    The engine is that of `simulated_label`.
    """

    grasps: int = Field(160, ge=1)
    """grasps of each object in free space, and as many on a table; the standard errors of the
    success rates are at most 0.5 / the square root of this number"""


class NaiveGraspParameters(ParameterGroup):
    """The settings that naive grasps depend on."""

    seed: Seed
    gripper: Gripper
    quality: Quality
    trials: Lifting
    simulated_label: SimulatedLabel
    naive_grasp: NaiveGrasp


class TrialParameters(ParameterGroup):
    """The settings that simulated trials depend on."""

    seed: Seed
    gripper: Gripper
    trials: TrialProtocol
    planning_time: PlanningTime = PLANNING_TIME


class ClutterParameters(ParameterGroup):
    """The settings that rounds of clearing a table depend on."""

    seed: Seed
    gripper: Gripper
    clutter: Clutter
    planning_time: PlanningTime = PLANNING_TIME


class SimulatedTrials(TrialParameters):
    """Simulated trials of a grasp detector."""

    detector: DetectorConfig


class ClearedTables(ClutterParameters):
    """Rounds of clearing a table with a grasp detector."""

    detector: DetectorConfig


class NaiveGrasps(NaiveGraspParameters):
    """Naive grasps of objects with a gripper."""

    material: Material
