"""The same grasps in every engine: `python studies/engines/same_grasps.py FOLDER [VARIANT ...]`.

Ten of the collision-free labelled grasps of each object of the evaluation set are executed on the
floating object, as in `egad.sim.labelled_trials`: in the same pose in all engines, once exactly
and once with the errors of a typical real cell. A variant is an engine, or an engine with one cause
of disagreement switched (`SWITCHES`). The results go to one file for each object in FOLDER; what is
there is not simulated again. Last, a mug is tried. `same_grasps_page.py` prints the tables.
"""

import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from time import process_time
from types import ModuleType

import mujoco
import numpy as np
import pandas as pd
import trimesh

import egad
from egad.bench import CellErrors
from egad.bench.cell_errors import EXACT, Deviation, draw
from egad.bench.parameters import NAMED_ERRORS
from egad.friction import FRICTION
from egad.grippers import GRIPPERS
from egad.objects import NamedMesh, named_meshes
from egad.random import generator
from egad.sim import ARMS, ENGINES, Arm, Lifting, Model, World, mujoco_world, open_world
from egad.sim.execution import execute
from egad.sim.labelled_trials import floating_pose
from egad.sim.model import simulated
from egad.sim.pybullet_world import PyBulletWorld

GRASPS, SAMPLED, MUG = 10, 200, "mug"
GRIPPER = GRIPPERS["egad_75mm"].model_copy(update={"friction": FRICTION})
ERRORS: dict[str, CellErrors] = {name: NAMED_ERRORS[name] for name in ("none", "typical")}
Change = Callable[[World], None]


def in_mujoco(**options: float) -> Change:
    """Other options of the model."""

    def change(world: World) -> None:
        for name, value in options.items():
            setattr(world.engine.opt, name, value)

    return change


def without_torsion_in_mujoco(world: World) -> None:
    """Pads that do not resist twisting."""
    world.engine.geom_condim[:] = 3


def soft_in_mujoco(world: World) -> None:
    """The impedance that is MuJoCo's default."""
    world.engine.geom_solimp[:, :3] = 0.9, 0.95, 0.001


def soft_with_half_the_step(world: World) -> None:
    """Both."""
    soft_in_mujoco(world)
    world.engine.opt.timestep = 1 / 960


def damped_in_mujoco(world: World) -> None:
    """Twice the critical damping."""
    world.engine.geom_solref[:, 1] = 2.0


def in_pybullet(**options: int) -> Change:
    """Other options of the solver."""
    return lambda world: world.client.setPhysicsEngineParameter(**options)


def of_object_in_pybullet(**options: float) -> Change:
    """Another dynamics of the object."""
    return lambda world: world.client.changeDynamics(world.objects[0], -1, **options)


def without_torsion_in_pybullet(world: World) -> None:
    """Pads that do not resist twisting; the hand is loaded later."""
    loaded = PyBulletWorld._set_friction  # noqa: SLF001

    def set_friction(joints: int) -> None:
        loaded(world, joints)
        for link in range(joints):
            robot = world._robot  # noqa: SLF001
            world.client.changeDynamics(robot, link, spinningFriction=0.0)

    world._set_friction = set_friction  # noqa: SLF001


# What is applied after a reset; or, for Drake, which constants of its scene differ.
SWITCHES: dict[str, dict[str, Change]] = {
    "mujoco": {
        "one point per pair": in_mujoco(
            disableflags=mujoco.mjtDisableBit.mjDSBL_AUTORESET
            | mujoco.mjtDisableBit.mjDSBL_MULTICCD
        ),
        "no torsion": without_torsion_in_mujoco,
        "friction cone a pyramid": in_mujoco(cone=mujoco.mjtCone.mjCONE_PYRAMIDAL),
        "friction as stiff as normal forces": in_mujoco(impratio=1.0),
        "soft contacts": soft_in_mujoco,
        "twice the damping": damped_in_mujoco,
        "half the step": in_mujoco(timestep=1 / 960),
        "soft contacts and half the step": soft_with_half_the_step,
    },
    "pybullet": {
        "no torsion": without_torsion_in_pybullet,
        "no friction anchors": of_object_in_pybullet(frictionAnchor=0),
        "margin of 1 mm": of_object_in_pybullet(collisionMargin=1e-3),
        "soft contacts": of_object_in_pybullet(contactStiffness=1e5, contactDamping=300.0),
        "twice the iterations": in_pybullet(numSolverIterations=300),
        "half the step": in_pybullet(numSubSteps=2),
    },
}
# Of Drake only the grasps on which engines part are repeated, as it takes longer.
DRAKE: dict[str, dict[str, float]] = {
    "pads five times as soft": {"PAD_MODULUS": 4e5},
    "pads twenty times as stiff": {"PAD_MODULUS": 4e7},
    "four times the relaxation time": {"RELAXATION_TIME": 0.02},
}
VARIANTS = [
    *ENGINES,
    *(f"{engine}: {name}" for engine, switches in SWITCHES.items() for name in switches),
    *(f"drake: {name}" for name in DRAKE),
]


def mug() -> trimesh.Trimesh:
    """A mug of 60 mm across and 80 mm high, with walls of 4 mm and a handle, metres."""
    outside = trimesh.creation.cylinder(0.03, 0.08)
    inside = trimesh.creation.cylinder(0.026, 0.08).apply_translation([0, 0, 0.004])
    handle = trimesh.creation.torus(0.022, 0.004)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    whole = trimesh.boolean.union([outside, handle.apply_translation([0.03, 0, 0])])
    return trimesh.boolean.difference([whole, inside])


def prepared(folder: Path, label: str) -> tuple[Model, pd.DataFrame]:
    """The model of an object and its grasps, which are kept in a file."""
    path = folder / f"{label}.pickle"
    if not path.is_file():
        if label == MUG:
            target, rule = NamedMesh(MUG, MUG, mug), "none"
        else:
            targets, rule = named_meshes(egad.load("evaluation-set")), "paper"
            (target,) = (each for each in targets if each.label == label)
        mesh, model = simulated(target, GRIPPER, rule)
        grasps = egad.sample_grasps(mesh, GRIPPER, n=SAMPLED, seed=0).to_frame()
        free = grasps[grasps["collision_free"]]
        chosen = np.sort(generator(0, "engines", label).permutation(len(free))[:GRASPS])
        path.write_bytes(pickle.dumps((model, free.iloc[chosen])))
    model, grasps = pickle.loads(path.read_bytes())  # noqa: S301 (our own)
    return model, grasps.assign(order=range(len(grasps)))


@contextmanager
def world_of(variant: str, model: Model, arm: Arm) -> Iterator[tuple[World, Change]]:
    """A world of a variant, and what is to be done after a reset."""
    engine, _, name = variant.partition(": ")
    kept: dict[tuple[ModuleType, str], float] = {}
    if engine == "drake" and name:
        drake_model = import_module("egad.sim.drake_model")  # it may not be installed
        for constant, value in DRAKE[name].items():
            kept[drake_model, constant] = getattr(drake_model, constant)
            setattr(drake_model, constant, value)
    if engine == "mujoco" and name.endswith("half the step"):
        kept[mujoco_world, "SUBSTEPS"] = mujoco_world.SUBSTEPS
        mujoco_world.SUBSTEPS *= 2
    change = SWITCHES.get(engine, {}).get(name, lambda _: None)
    try:
        with open_world(engine, [model], arm.robot) as world:
            yield world, change
    finally:
        for (module, constant), value in kept.items():
            setattr(module, constant, value)


def outcomes(
    variant: str, model: Model, grasps: pd.DataFrame, errors: str, label: str
) -> list[str]:
    """Outcomes of the grasps of an object."""
    arm = ARMS["axis"](GRIPPER)
    found = []
    with world_of(variant, model, arm) as (world, change):
        for row in grasps.to_dict("records"):
            deviation = EXACT
            if errors != "none":
                seed = int(generator(0, "engines", label, row["order"]).integers(2**31))
                deviation = draw(ERRORS[errors], seed, seed)
            found.append(_outcome(world, arm, row, deviation, change))
    return found


def _outcome(
    world: World, arm: Arm, row: Mapping[str, float], deviation: Deviation, change: Change
) -> str:
    pose, grasp = floating_pose(world.model, row, GRIPPER)
    world.mass_factor, world.friction_factor = deviation.mass, deviation.friction
    world.reset()
    change(world)
    world.place(pose)
    moved = deviation.apply(grasp, GRIPPER)
    contact = float(row["width"])
    return str(execute(world, arm, Lifting(), moved, afloat=True, contact=contact).outcome)


def parted(known: pd.DataFrame) -> list[int]:
    """Numbers of the grasps with typical errors that not all engines agree on."""
    rows = known[(known["errors"] == "typical") & known["variant"].isin(ENGINES)]
    successes = (rows["outcome"] == "success").groupby(rows["grasp"]).mean()
    return successes[successes.between(0, 1, inclusive="neither")].index.tolist()


def main(folder: Path, variants: list[str]) -> None:
    """Simulate what is not yet there."""
    folder.mkdir(parents=True, exist_ok=True)
    for label in [*egad.load("evaluation-set").table["label"], MUG]:
        path = folder / f"{label}.csv"
        known = pd.read_csv(path) if path.is_file() else pd.DataFrame(columns=["variant", "errors"])
        model, grasps = prepared(folder, label)
        for variant in variants:
            for errors in ERRORS if variant in ENGINES else ["typical"]:
                if ((known["variant"] == variant) & (known["errors"] == errors)).any():
                    continue
                chosen = grasps
                if variant.startswith("drake: "):
                    chosen = grasps[grasps["grasp"].isin(parted(known))]
                start = process_time()
                rows = pd.DataFrame(
                    {
                        "label": label,
                        "grasp": chosen["grasp"].to_numpy(),
                        "variant": variant,
                        "errors": errors,
                        "outcome": outcomes(variant, model, chosen, errors, label),
                    }
                )
                rows["seconds"] = (process_time() - start) / max(len(rows), 1)
                known = pd.concat([known, rows], ignore_index=True)
                known.to_csv(path, index=False)
        print(label, len(known), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:] or VARIANTS)
