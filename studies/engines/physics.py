"""The numbers in the section on physics of README.md.

Run `python studies/engines/physics.py results/D/bundle/G`. Each is a small experiment in both
engines; in PyBullet also with one of its settings changed.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from egad.bench import InitialPose, initial_poses
from egad.bench.trial_runner import DROP_HEIGHT
from egad.exchange import model_in, rows_by_id
from egad.geometry import Bundle
from egad.grippers import GRIPPERS
from egad.random import generator
from egad.sim import ARMS, TIME_STEP, Arm, Hand, HandPose, Model, Pose, World, build
from egad.sim.mujoco_world import MujocoWorld
from egad.sim.pybullet_world import PyBulletWorld

STANDING = np.array([0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)])  # the thickness is that along x
SIDE = 0.04
SAME = 15.0  # degrees
OBJECTS, DROPS = 13, 5
Change = Callable[[PyBulletWorld], None]


def nothing(_world: World) -> None:
    """The engine as it is."""


def without_anchors(scene: PyBulletWorld) -> None:
    """Contacts that forget where they stuck."""
    scene.client.changeDynamics(scene.objects[0], -1, frictionAnchor=0)


def with_iterations(count: int) -> Change:
    """Another number of iterations of the solver."""
    return lambda scene: scene.client.setPhysicsEngineParameter(numSolverIterations=count)


def opened(model: Model, force: float) -> tuple[PyBulletWorld, Arm]:
    """A world with a hand of some force."""
    arm = ARMS["axis"](GRIPPERS["egad_75mm"].model_copy(update={"force": force}))
    return PyBulletWorld([model], arm.robot), arm


def held(scene: World, arm: Arm, change: Callable[[Any], None]) -> Hand:
    """A cube or plate between the fingers."""
    scene.place(Pose(np.array([0.0, 0.0, SIDE / 2]), STANDING))
    change(scene)
    found = Hand(scene, arm, HandPose(0, 0, 0.01, 0), 0.065)
    found.close()
    return found


def pressed_in(
    force: float, change: Change = nothing, mass: float | None = None, thickness: float = SIDE
) -> float:
    """How deep the fingers sink into what they hold, both sides together, millimetres."""
    model = build(trimesh.creation.box((SIDE, SIDE, thickness)), 400.0, Bundle())
    if mass is not None:
        part = mass / model.mass
        model = replace(model, mass=mass, inertia=model.inertia * part)
    world, arm = opened(model, force)
    with world as scene:
        return 1000 * (thickness - held(scene, arm, change).opening())


def creep(change: Change) -> tuple[float, float]:
    """How far a cube sinks (mm) and turns (degrees) in 10 s at 20 N."""
    world, arm = opened(build(trimesh.creation.box((SIDE,) * 3), 400.0, Bundle()), 20.0)
    with world as scene:
        held(scene, arm, change).lift(0.2, 1.0)
        before = scene.pose()
        scene.step(2400)
        after = scene.pose()
    return 1000 * float(before.position[2] - after.position[2]), turn(before, after)


def opened_in_mujoco(
    model: Model, force: float, stiffness: float | None, impedance: float | None
) -> tuple[MujocoWorld, Arm]:
    """A world with a hand of some force, and another stiffness of friction or impedance."""
    arm = ARMS["axis"](GRIPPERS["egad_75mm"].model_copy(update={"force": force}))
    world = MujocoWorld([model], arm.robot)
    if stiffness is not None:
        world.engine.opt.impratio = stiffness
    if impedance is not None:
        world.engine.geom_solimp[:, :2] = impedance
    return world, arm


def pressed_into_mujoco(force: float, impedance: float | None = None) -> float:
    """How deep the fingers sink into a cube of 50 g, both sides together, millimetres."""
    model = build(trimesh.creation.box((SIDE,) * 3), 400.0, Bundle())
    scene, arm = opened_in_mujoco(model, force, None, impedance)
    return 1000 * (SIDE - held(scene, arm, nothing).opening())


def twisting(stiffness: float | None) -> float:
    """How fast a ball turns between pads under 0.8 of the torque they can bear, degrees/s."""
    ball = trimesh.creation.icosphere(4, SIDE / 2)
    model = build(ball, 400.0, Bundle(deviation=1e-5, max_vertices=1000))
    scene, arm = opened_in_mujoco(model, 20.0, stiffness, None)
    scene.place(Pose(np.array([0.0, 0.0, SIDE / 2]), STANDING))
    hand = Hand(scene, arm, HandPose(0, 0, SIDE / 2, 0), 0.065)
    hand.close()
    hand.lift(0.1, 1.0)
    friction, radius = arm.robot.gripper.pad
    body = scene.engine.body("object0").id
    for _ in range(60):
        scene.data.xfrc_applied[body, 3] = 0.8 * 2 * friction * 20.0 * 2 / 3 * radius
        scene.step()
    return float(np.degrees(scene.speeds()[1]))


def turn(before: Pose, after: Pose) -> float:
    """Angle between two poses, degrees."""
    trace = np.trace(after.matrix[:3, :3] @ before.matrix[:3, :3].T)
    return float(np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))))


def tilt(before: Pose, after: Pose) -> float:
    """Angle between the directions of the object that point up in two poses, degrees."""
    cosine = before.matrix[2, :3] @ after.matrix[2, :3]
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def lay_as_before(bundle: Path, tilted: bool) -> list[bool]:
    """Whether objects that a hand lets go come to rest as they lay before: 65 drops."""
    found = []
    rows = sorted(rows_by_id(bundle).values(), key=lambda row: str(row["label"]))
    for row in rows[:: -(-len(rows) // OBJECTS)]:
        rng = generator(0, "physics", row["id"])
        with PyBulletWorld([model_in(bundle, row)]) as scene:
            mesh = scene.model.mesh
            for _ in range(DROPS):
                lying = fallen(scene, next(initial_poses(mesh, None, rng)).pose)
                let_go = next(initial_poses(mesh, InitialPose("from_hand", lying), rng)).pose
                up = Pose(lying.position + np.array([0.0, 0.0, DROP_HEIGHT]), lying.quaternion)
                found.append(tilt(lying, fallen(scene, let_go if tilted else up)) < SAME)
    return found


def fallen(scene: World, start: Pose) -> Pose:
    """Where the object lies 4 s after it was let go."""
    scene.reset()
    scene.place(start)
    scene.step(round(4 / TIME_STEP))
    return scene.pose()


def main(bundle: Path) -> None:
    """Print the numbers."""
    for force in (70.0, 100.0):
        for count in (50, 100, 150):
            by = pressed_in(force, with_iterations(count))
            print(f"{count} iterations, {force:.0f} N: {by:.2f} mm")
    for thickness in (0.005, 0.01, 0.02):
        true = 400.0 * thickness * SIDE**2
        own, set_to = (pressed_in(70.0, nothing, mass, thickness) for mass in (true, None))
        print(f"plate of {1000 * thickness:.0f} mm: {own:.2f} mm; with 50 g {set_to:.2f} mm")
    for name, change in (("with", nothing), ("without", without_anchors)):
        sunk, turned = creep(change)
        print(f"{name} anchors: sinks by {sunk:.3f} mm and turns by {turned:.2f} degrees in 10 s")
    for impedance in (None, 0.95):
        by = [pressed_into_mujoco(force, impedance) for force in (20.0, 100.0)]
        print(f"MuJoCo, impedance {impedance or 'as it is'}: {by[0]:.3f} and {by[1]:.3f} mm")
    for stiffness in (None, 10.0):
        print(f"MuJoCo, impratio {stiffness or 'as it is'}: {twisting(stiffness):.2f} degrees/s")
    for name, tilted in (("upright", False), ("tilted", True)):
        same = lay_as_before(bundle, tilted)
        print(f"let go {name}: {sum(same)} of {len(same)} lie as before")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
