"""Settings of simulated grasps."""

import importlib.util
from typing import Literal, get_args

from pydantic import Field

from egad._util.parameters import ParameterGroup, Parameters
from egad.errors import UserError, check_name
from egad.geometry import Material
from egad.grasps import Quality
from egad.grippers import Gripper

# A Panda stops at about this contact force; lighter contacts only push the object aside.
COLLISION_FORCE = 20.0
FastEngine = Literal["mujoco", "pybullet"]
EngineName = Literal[FastEngine, "drake"]  # the default first
FAST_ENGINES: tuple[FastEngine, ...] = get_args(FastEngine)
ENGINES: tuple[EngineName, ...] = get_args(EngineName)
Contact = Literal["collided", "close", "ignore"]
"""What a contact during the approach means; a setting says which of these it allows."""
CONTACTS: dict[Contact, str] = {
    "collided": "the attempt fails",
    "close": "the hand stops and closes there",
    "ignore": "the hand moves on",
}


def contacts_in_words(*allowed: Contact) -> str:
    """What a contact means in a setting that allows these, for its description."""
    return "; ".join(f"{each}: {CONTACTS[each]}" for each in allowed)


def check_engine(name: str) -> None:
    """Raise UserError unless there is an engine of this name and it is installed."""
    check_name("engine", name, ENGINES)
    if not is_installed(name):
        extra = "drake" if name == "drake" else "sim"
        old = " (it has packages for Python 3.11 and older only)" if name == "pybullet" else ""
        raise UserError(
            f"the physics engine {name} is not installed: pip install 'egad[{extra}]'{old}, or "
            f"choose another one of {', '.join(ENGINES)}"
        )


def is_installed(engine: str) -> bool:
    """Whether the package of an engine is installed."""
    return importlib.util.find_spec("pydrake" if engine == "drake" else engine) is not None


class Lifting(Parameters):
    """Execution of a grasp."""

    engine: EngineName = ENGINES[0]
    """physics engine; pybullet has packages for Python 3.11 and older only; drake is an extra, and
    takes 30 to 50 times as long as mujoco"""
    arm: Literal["axis", "panda"] = "axis"
    """arm that moves the hand: a vertical axis, or a Franka Panda, which takes 2 to 3 times as
    long"""
    lift_height: float = Field(0.4, gt=0, le=1)
    """height that a successful grasp lifts the object to, metres"""
    hold_time: float = Field(2.0, ge=0)
    """time that the object must stay at that height, seconds"""


class LabelAgreement(Parameters):
    """Labelled grasps executed in simulation, to validate their quality."""

    grasps: int = Field(2000, ge=1)
    """grasps executed, in equal numbers for all objects of the evaluation set"""


class SimulatedLabel(Parameters):
    """Simulated labels of grasps: closed in free space, shaken and lifted."""

    engine: EngineName = ENGINES[0]
    """physics engine, as in `trials`"""
    grasps: int = Field(100, ge=1)
    """maximum number of collision-free grasps of each object to simulate"""


class SimulatedLabelParameters(ParameterGroup):
    """The settings that simulated labels depend on."""

    gripper: Gripper
    quality: Quality
    trials: Lifting
    simulated_label: SimulatedLabel


class LabelTrialParameters(ParameterGroup):
    """The settings that the execution of labelled grasps depends on."""

    seed: int
    gripper: Gripper
    quality: Quality
    trials: Lifting
    agreement: LabelAgreement


class SimulatedLabels(SimulatedLabelParameters):
    """Simulated labels of the grasps of a gripper."""

    material: Material
