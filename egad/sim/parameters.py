"""Simulated grasping trials, and the grasp detectors that are tried."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Pixels
from egad.grasps.parameters import Gripper, Quality


class Lifting(Parameters):
    """How a grasp is carried out."""

    arm: Literal["axis", "panda"] = Field(
        "axis",
        description="what carries the hand: axis: a vertical axis; panda: a Franka Panda arm, "
        "which takes half as long again",
    )
    lift_height: float = Field(
        0.4, gt=0, le=1, description="an object held this high counts, metres"
    )
    hold_time: float = Field(2.0, ge=0, description="seconds that it must stay held up there")


class Trials(Lifting):
    """Simulated grasping trials."""

    attempts: int = Field(10, ge=1, description="attempts an object")
    reset: Literal["continue", "redrop"] = Field(
        "continue",
        description="continue: after a success the hand tilts the object and lets it fall, after a "
        "failure it stays where it lies, as with a real robot; redrop: every attempt begins with a "
        "drop in a random orientation, the same for all detectors",
    )
    drop_height: Length = Field(0.1, description="from the table to the lowest point, metres")
    workspace: Length = Field(
        0.12, description="an object further than this from the middle is put back, metres"
    )
    image: tuple[Pixels, Pixels] = Field(
        (640, 480), description="width and height of the depth image, pixels"
    )
    field_of_view: float = Field(
        75.0, gt=1, lt=170, description="of the width of the image, degrees"
    )
    camera_height: Length = Field(0.6, description="camera above the table, metres")
    depth_noise: float = Field(
        0.0,
        ge=0,
        description="standard deviation of the disparity in pixels, as of a stereo camera; a D435 "
        "has about 0.1",
    )
    planning_time: float = Field(
        60.0, gt=0, description="seconds that a detector may take; then the attempt has failed"
    )


class Agreement(Parameters):
    """Labelled grasps carried out, to see what their qualities are worth."""

    grasps: int = Field(
        2000, ge=1, description="grasps carried out, as many of each object of the evaluation set"
    )


class TrialParameters(ParameterGroup):
    """What simulated trials depend on."""

    seed: int
    gripper: Gripper
    trials: Trials


class LabelTrialParameters(ParameterGroup):
    """What the execution of labelled grasps depends on."""

    seed: int
    gripper: Gripper
    quality: Quality
    trials: Lifting
    agreement: Agreement
