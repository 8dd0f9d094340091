"""Worlds for tests: in each engine, with a hand on an arm."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from egad.grippers import GRIPPERS, Gripper
from egad.sim.arms import ARMS, HandPose
from egad.sim.engines import open_world
from egad.sim.jaws import Hand
from egad.sim.model import Model
from egad.sim.parameters import ENGINES, FAST_ENGINES, EngineName, is_installed
from egad.sim.world import World


def _each(engines: Sequence[EngineName]) -> pytest.MarkDecorator:
    params = [
        pytest.param(name, marks=pytest.mark.skipif(not is_installed(name), reason="not installed"))
        for name in engines
    ]
    return pytest.mark.parametrize("engine", params)


EACH_ENGINE, EACH_FAST_ENGINE = _each(ENGINES), _each(FAST_ENGINES)
EACH_ARM = pytest.mark.parametrize("arm", list(ARMS))
HAND = GRIPPERS["egad_75mm"]


def start(engine: EngineName, model: Model, gripper: Gripper = HAND, arm: str = "axis") -> World:
    """A world with the robot that `hand_at` brings into it."""
    return open_world(engine, [model], ARMS[arm](gripper).robot)


def hand_at(world: World, hand_pose: HandPose, width: float, arm: str = "axis") -> Hand:
    """A hand in a world that `start` made with the same arm."""
    assert world.robot is not None
    return Hand(world, ARMS[arm](world.robot.gripper), hand_pose, width)


def twist(world: Any, torque: Sequence[float]) -> None:
    """Turn the object by a torque (N m) in the next step."""
    pull(world, (0.0, 0.0, 0.0), torque)


def pull(world: Any, force: Sequence[float], torque: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
    """Pull the object at its center of mass (N), and turn it (N m), in the next step."""
    if hasattr(world, "data"):
        world.data.xfrc_applied[world.engine.body("object0").id] = [*force, *torque]
    elif hasattr(world, "scene"):
        plant = world.scene.plant
        speed = plant.GetJointByName("object0").velocity_start()
        loads = np.zeros(plant.num_velocities())
        loads[speed : speed + 6] = [*torque, *force]
        plant.get_applied_generalized_force_input_port().FixValue(world.context, loads)
    else:
        body, at = world.objects[0], world.pose().position.tolist()
        world.client.applyExternalForce(body, -1, force, at, 2)  # in the world's frame
        world.client.applyExternalTorque(body, -1, torque, 2)
