"""Settings of simulated grasping trials."""

from typing import Literal, get_args

from pydantic import Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Pixels, Seed
from egad.grasps import Gripper, Quality

EngineName = Literal["pybullet", "mujoco"]
ENGINES: tuple[EngineName, ...] = get_args(EngineName)
EngineChoice = Literal["auto", EngineName]


class Lifting(Parameters):
    """Execution of a grasp."""

    engine: EngineChoice = Field(
        "auto",
        description="physics engine; auto: pybullet if it is installed, as on Python 3.11, else "
        "mujoco",
    )
    arm: Literal["axis", "panda"] = Field(
        "axis",
        description="arm that moves the hand: a vertical axis, or a Franka Panda, which takes 1.5 "
        "times as long",
    )
    lift_height: float = Field(
        0.4, gt=0, le=1, description="height that a successful grasp lifts the object to, metres"
    )
    hold_time: float = Field(
        2.0, ge=0, description="time that the object must stay at that height, seconds"
    )


class Trials(Lifting):
    """Simulated grasping trials."""

    attempts: int = Field(10, ge=1, description="attempts per object")
    reset: Literal["continue", "redrop"] = Field(
        "continue",
        description="continue: after a success the hand tilts and drops the object, after a "
        "failure the object stays where it is, as with a real robot; redrop: every attempt starts "
        "with a drop in a random orientation, the same for all detectors",
    )
    drop_height: Length = Field(
        0.1, description="height of the lowest point above the table before a drop, metres"
    )
    workspace: Length = Field(
        0.12, description="objects further than this from the center are moved back, metres"
    )
    image: tuple[Pixels, Pixels] = Field(
        (640, 480), description="width and height of the depth image, pixels"
    )
    field_of_view: float = Field(
        75.0, gt=1, lt=170, description="horizontal field of view of the camera, degrees"
    )
    camera_height: Length = Field(0.6, description="height of the camera above the table, metres")
    depth_noise: float = Field(
        0.0,
        ge=0,
        le=10,
        description="standard deviation of the disparity, as in a stereo camera, pixels; about 0.1 "
        "for a D435; if not 0, the image also has holes beside edges and on steep surfaces",
    )
    planning_time: float = Field(
        60.0,
        gt=0,
        description="time limit of a detector, seconds; an attempt that exceeds it fails",
    )


class Agreement(Parameters):
    """Labelled grasps executed in simulation, to validate their quality."""

    grasps: int = Field(
        2000,
        ge=1,
        description="grasps executed, in equal numbers for all objects of the evaluation set",
    )


class SimulatedLabel(Parameters):
    """Simulated labels of grasps: closed in free space, shaken and lifted."""

    grasps: int = Field(
        100, ge=1, description="collision-free grasps of each object that are simulated"
    )


class SimulatedLabelParameters(ParameterGroup):
    """The settings that simulated labels depend on."""

    gripper: Gripper
    quality: Quality
    trials: Lifting
    simulated_label: SimulatedLabel


class TrialParameters(ParameterGroup):
    """The settings that simulated trials depend on."""

    seed: Seed
    gripper: Gripper
    trials: Trials


class LabelTrialParameters(ParameterGroup):
    """The settings that the execution of labelled grasps depends on."""

    seed: int
    gripper: Gripper
    quality: Quality
    trials: Lifting
    agreement: Agreement
