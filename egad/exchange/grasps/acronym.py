"""ACRONYM files: one HDF5 file per object, with the grasps of a gripper."""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import QUALITIES, simulated_by_object
from egad.exchange.hdf5 import add_array, add_group, check_key, writing
from egad.exchange.new_folder import check_not_file
from egad.exchange.objects.simulation import inertia_tensor
from egad.exchange.parameters import Acronym, AcronymFiles, NamedGripper
from egad.friction import FRICTION
from egad.grasps import Grasps
from egad.grippers import Gripper, finger_span
from egad.io import SUMS, write_obj
from egad.sim import SimulationObject, held_when_shaken, with_outcome
from egad.tables import parquet
from egad.tables.grasping import MOTIONS, SCALES
from egad.tables.objects import OBJECTS

KEYS = ({"grasps/transforms"},)
log = logging.getLogger(__name__)
# From the origin of its hand, the flange of a Franka Panda, to the fingertips, metres.
PANDA_REACH = 0.11217
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
class AcronymObject:
    """The object of a file, scaled by `scale`: metres, kilograms, in the frame of its mesh."""

    file: str
    scale: float
    volume: float
    mass: float
    com: Floats
    inertia: Floats
    friction: float


def write_acronym(
    path: Path, body: AcronymObject, hand: NamedGripper, grasps: pd.DataFrame, least: float
) -> None:
    """Write the file of an object.

    ACRONYM's label `flex/object_in_gripper` is 1 for grasps that held; motions are NaN for those
    that did not get that far. Our `egad/success` is a label without simulation.
    """
    with writing(path) as file:
        for name, value in (vars(body) | {"density": body.mass / body.volume}).items():
            add_group(file, "object")[name] = value
        jaws = add_group(file, "gripper")
        jaws["type"] = hand.name
        jaws["configuration"] = np.full(2, hand.gripper.opening / 2)
        _add_grasps(file, hand.gripper, grasps, least)


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Write `LABEL.h5`, and `meshes/LABEL.obj`: see `egad.exchange.registry`."""
    body = AcronymObject(
        file=f"meshes/{label}.obj",
        scale=1.0,
        volume=made.physics.volume,
        mass=made.physics.mass,
        com=np.asarray(made.physics.com),
        inertia=made.physics.inertia,
        friction=FRICTION,
    )
    write_obj(made.mesh, folder / body.file)
    least = Acronym().min_robust_success_rate
    write_acronym(folder / f"{label}.h5", body, hand, grasps, least)


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of a file in the frame of its mesh times `object/scale`; ours have widths."""
    depth = options.depth_or(PANDA_REACH, "an ACRONYM file")
    return files.file_grasps(
        content["grasps/transforms"],
        files.hand_in_frame(options.frame or "x z", depth),
        widths=content.get("grasps/widths", np.nan),
        success=content.get("grasps/qualities/flex/object_in_gripper", np.nan),
    )


def is_ours(path: Path) -> bool:
    """Whether a file is one that `write_acronym` wrote, or holds the checksums of such files."""
    if path.name == SUMS:
        return True
    if path.suffix != ".h5" or not path.is_file():
        return False
    try:
        with h5py.File(path, "r") as file:
            return OWN in file
    except OSError:
        return False


def panda_poses(poses: Floats, fingertip: float) -> Floats:
    """Poses of ACRONYM's hand, (n, 4, 4), with its fingertips at ours, `fingertip` metres ahead."""
    moved = poses.copy()
    moved[:, :3, 3] -= (PANDA_REACH - fingertip) * poses[:, :3, 2]
    return moved


def _add_grasps(file: h5py.File, gripper: Gripper, grasps: pd.DataFrame, least: float) -> None:
    group = add_group(file, "grasps")
    grasps = with_outcome(grasps)
    add_array(group, "transforms", panda_poses(Grasps(grasps).poses, finger_span(gripper)[1]))
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
        f"{least} of the perturbed copies hold"
    )
    flex = add_group(group, "qualities/flex")
    add_array(flex, "object_in_gripper", held_when_shaken(grasps).astype(np.int64))
    for name, motion in FLEX_MOTIONS.items():
        add_array(flex, name, grasps[motion].to_numpy(dtype=np.float64))


def run(
    settings: AcronymFiles,
    gripper: str,
    objects: Path,
    scales: Path,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write a file for each object that has grasps, for `D` as the root of the meshes."""
    check_not_file(out)
    if foreign := [path.name for path in sorted(out.glob("*")) if not is_ours(path)]:
        raise UserError(
            f"--out {out}: {foreign[0]} is not from an earlier export and would be lost; "
            "give a separate folder"
        )
    check_key(gripper, "gripper")
    table = parquet.read(objects, OBJECTS)
    factors = parquet.read(scales, SCALES).set_index("label")["factor"].to_dict()
    known = {row["label"]: row for row in parquet.records(table) if row["label"] in factors}
    hand = NamedGripper(gripper, settings.gripper)
    written = 0
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        for label, found in simulated_by_object(simulated_grasps):
            if label not in known:
                raise UserError(
                    f"{simulated_grasps}: object {label!r} is not in {objects} and {scales}"
                )
            body = scaled_body(known[label], factors[label], settings.quality.friction)
            path = folder / f"{check_key(label)}.h5"
            write_acronym(path, body, hand, found, settings.acronym.min_robust_success_rate)
            written += 1
    log.info("%d objects", written)


def scaled_body(row: dict[str, Any], factor: float, friction: float) -> AcronymObject:
    """The object of a row of `tables.objects.OBJECTS`, scaled about the origin of its mesh."""
    return AcronymObject(
        file=f"meshes/{row['label']}.obj",
        scale=factor,
        volume=row["volume"] * factor**3,
        mass=row["mass"] * factor**3,
        com=factor * np.array([row[f"com_{part}"] for part in "xyz"]),
        inertia=inertia_tensor(row) * factor**5,
        friction=friction,
    )
