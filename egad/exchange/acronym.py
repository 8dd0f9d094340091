"""ACRONYM files: one HDF5 file per object, with the grasps of a gripper."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.exchange import sums
from egad.exchange.hdf5 import add_array, add_group, writing
from egad.grasps import Grasps, held_when_shaken, panda_poses, with_outcome
from egad.tables.grasping import MOTIONS

Floats = NDArray[np.float64]
QUALITIES = (
    "quality",
    "robust_quality",
    "robust_quality_std",
    "robust_success_rate",
    "fits",
    "collision_free",
    "needed_opening",
)
OWN = "grasps/qualities/egad"
FLEX_MOTIONS = {
    f"object_motion_during_{phase}_{theirs}": f"simulated_{phase}_{ours}"
    for phase in ("closing", "shaking")
    for theirs, ours in (("linear", "shift"), ("angular", "turn"))
}
COLUMNS = [
    *(f"{name}_{part}" for name in ("center", "axis", "approach") for part in "xyz"),
    "width",
    *QUALITIES,
    "simulated_outcome",
    "simulated_success",
    *MOTIONS,
]


@dataclass(frozen=True)
class Body:
    """The object of a file, scaled: metres, kilograms, in the frame of its mesh.

    Attributes:
        file: The unscaled mesh, relative to the root of the meshes.
        scale: Factor to scale it by.
        volume: m3.
        mass: kg.
        com: (3,) center of mass.
        inertia: (3, 3) about the center of mass.
        friction: Coulomb coefficient that the grasps were rated with.
    """

    file: str
    scale: float
    volume: float
    mass: float
    com: Floats
    inertia: Floats
    friction: float


@dataclass(frozen=True)
class Jaws:
    """The hand of a file.

    Attributes:
        name: Of the gripper.
        opening: Widest, metres.
        fingertip: How far the fingers reach beyond the contacts, metres.
    """

    name: str
    opening: float
    fingertip: float


def write_acronym(path: Path, body: Body, jaws: Jaws, grasps: pd.DataFrame, least: float) -> None:
    """Write the file of an object.

    ACRONYM's label `flex/object_in_gripper` is 1 if both fingers still held the object after it was
    shaken in simulation, and 0 for the others and for grasps at which the open hand collides. Its
    motions are not a number where it did not come to that. Grasps of which nothing is known, for
    only some of an object were simulated, are left out. Our own `egad/success` is a label without
    simulation, and says in its attribute what it means.

    Args:
        path: A name that ends in `.h5`.
        body: The object.
        jaws: The hand.
        grasps: One row per grasp, with `COLUMNS`.
        least: Part of the disturbed copies that must hold the object for `egad/success`.
    """
    with writing(path) as file:
        for name, value in (vars(body) | {"density": body.mass / body.volume}).items():
            add_group(file, "object")[name] = value
        hand = add_group(file, "gripper")
        hand["type"] = jaws.name
        hand["configuration"] = np.full(2, jaws.opening / 2)
        _add_grasps(file, jaws, grasps, least)


def is_ours(path: Path) -> bool:
    """Whether a file is one that `write_acronym` wrote, or the sums of them."""
    if path.name == sums.NAME:
        return True
    if path.suffix != ".h5" or not path.is_file():
        return False
    try:
        with h5py.File(path, "r") as file:
            return OWN in file
    except OSError:
        return False


def _add_grasps(file: h5py.File, jaws: Jaws, grasps: pd.DataFrame, least: float) -> None:
    group = add_group(file, "grasps")
    grasps = with_outcome(grasps)
    add_array(group, "transforms", panda_poses(Grasps(grasps).poses, jaws.fingertip))
    add_array(group, "widths", grasps["width"])
    own = add_group(group, "qualities/egad")
    for name in QUALITIES:
        values = grasps[name].to_numpy()
        add_array(own, name, values.astype(np.int64) if values.dtype == bool else values)
    success = grasps["collision_free"] & (grasps["robust_success_rate"] >= least)
    add_array(own, "success", success.to_numpy(dtype=np.int64))
    own["success"].attrs["meaning"] = (
        "not simulated: 1 if the open hand touches nothing at the grasp nor on its straight way "
        "in, at the best of the approach angles tried, and at least "
        f"{least} of the disturbed copies hold"
    )
    flex = add_group(group, "qualities/flex")
    add_array(flex, "object_in_gripper", held_when_shaken(grasps).astype(np.int64))
    for name, motion in FLEX_MOTIONS.items():
        add_array(flex, name, grasps[motion].to_numpy(dtype=np.float64))
