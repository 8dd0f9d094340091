"""dexnet: the Dex-Net database of a dataset, with the labelled grasps of a gripper."""

import logging
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.dexnet_database import MEASURES, add_dataset, add_grasps
from egad.exchange.grasp_tables import QUALITIES, by_object
from egad.exchange.hdf5 import DamagedError, check_key, copy_group, sound_keys, writing
from egad.exchange.parameters import DexNetDatabase
from egad.grasps import CONE_FACES, ROBUST_TORQUE_SCALING, SPREAD, approach_directions, vectors
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad.tables.objects import OBJECTS

log = logging.getLogger(__name__)
KEYS = ({"dexnet"},)
METRICS = {"ferrari_canny": "quality", "robust_ferrari_canny": "robust_quality"}
METRICS |= {"robust_ferrari_canny_std": "robust_quality_std"} | {n: n for n in QUALITIES[3:]}
OWN = tuple(METRICS)[2:]
COLUMNS = [
    *(f"{name}_{part}" for name in ("center", "axis", "approach") for part in "xyz"),
    *METRICS.values(),
]


def run(
    settings: DexNetDatabase,
    dataset: Path,
    gripper: str,
    parts: list[Path],
    grasps: Path,
    out: Path,
) -> None:
    """Combine the objects of all shards, and add their grasps; a damaged shard is removed."""
    check_names(dataset, gripper, grasps)
    homes, labels = _homes(parts, (dataset / "parts").resolve()), parquet.distinct(grasps, "label")
    if lost := sorted(labels - homes.keys()):
        raise UserError(f"{grasps}: object {lost[0]!r} is not among the written objects")
    found = by_object(grasps, COLUMNS)
    with writing(out) as file:
        meanings = {name: _meaning(OBJECTS, name) for name in MEASURES}
        objects = add_dataset(file, dataset.absolute().name, metrics(settings), meanings)
        for key in progress(sorted(homes), "writing grasps", len(homes)):
            with h5py.File(homes[key], "r") as part:
                copy_group(part["objects"][key], objects.create_group(key))
            rows = next(found)[1] if key in labels else None
            add_grasps(objects[key], gripper, *_grasps(settings, rows))
    log.info("%d objects", len(homes))


def check_names(dataset: Path, gripper: str, grasps: Path) -> None:
    """Raise UserError or TableError if a name is not allowed or the table lacks columns."""
    check_key(dataset.absolute().name, "dataset")
    check_key(gripper, "gripper")
    parquet.check_columns(grasps, ["label", *COLUMNS])


def _homes(parts: list[Path], ours: Path) -> dict[str, Path]:
    """The part that each object is in; a damaged one is removed if it is in our folder."""
    homes: dict[str, Path] = {}
    for part in parts:
        for key in _keys(part, part.resolve().parent == ours):
            if key in homes:
                raise UserError(f"object {key!r} is in {homes[key]} and again in {part}")
            homes[key] = part
    return homes


def _keys(part: Path, ours: bool) -> list[str]:
    try:
        return sound_keys(part, "objects")
    except DamagedError as error:
        if not ours:
            raise
        part.unlink()
        raise UserError(
            f"{part}: truncated or damaged ({error.reason}); it was removed, and the next run of "
            "snakemake creates it again"
        ) from error


def frames(axes: Floats) -> Floats:
    """Rotations (n, 3, 3) of Dex-Net's frame at angle 0: y closes, x approaches horizontally."""
    forward = approach_directions(axes)
    return np.stack([forward, axes, np.cross(forward, axes)], axis=2)


def angles(axes: Floats, approaches: Floats) -> Floats:
    """Dex-Net's approach angles, radians, (n,): `cos(a) x + sin(a) z` of the frame at angle 0."""
    there = frames(axes)
    along = np.einsum("nk,nk->n", there[:, :, 0], approaches)
    aside = np.einsum("nk,nk->n", there[:, :, 2], approaches)
    return np.asarray(np.arctan2(aside, along))


def configurations(centers: Floats, axes: Floats, approaches: Floats, opening: float) -> Floats:
    """Dex-Net's (n, 10): center, axis, opening, approach angle, jaw width (0) and opening (0)."""
    rest = np.zeros((len(centers), 4))
    rest[:, 0] = opening
    rest[:, 1] = angles(axes, approaches)
    return np.hstack([centers, axes, rest])


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of one object with one gripper, from the direction that their angle says."""
    name = files.one_object(list(content["dexnet"]), options, "objects or grippers")
    with h5py.File(content["path"]) as file:
        grasps = sorted(file[content["dexnet"][name]].values(), key=lambda each: each.attrs["id"])
        numbers = np.stack([each.attrs["configuration"] for each in grasps])
        score = [each["metrics"].attrs.get("robust_ferrari_canny", np.nan) for each in grasps]
    axes, turns, there = numbers[:, 3:6], numbers[:, 7:8], frames(numbers[:, 3:6])
    ahead = np.cos(turns) * there[:, :, 0] + np.sin(turns) * there[:, :, 2]
    matrices = np.tile(np.eye(4), (len(numbers), 1, 1))
    matrices[:, :3] = np.stack([ahead, axes, np.cross(ahead, axes), numbers[:, :3]], axis=2)
    place = files.hand_in_frame(options.frame or "y x", options.depth or 0.0)
    return files.file_grasps(matrices, place, openings=numbers[:, 6], score=score)


def _grasps(
    settings: DexNetDatabase, rows: pd.DataFrame | None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    if rows is None:
        return np.empty((0, 10)), {}
    centers, axes, approaches = (vectors(rows, name) for name in ("center", "axis", "approach"))
    values = {name: rows[column].to_numpy(dtype=float) for name, column in METRICS.items()}
    return configurations(centers, axes, approaches, settings.gripper.opening), values


def _meaning(schema: pa.Schema, column: str) -> str:
    about: dict[bytes, bytes] = schema.field(column).metadata
    meaning, unit = about[b"meaning"].decode(), about[b"unit"].decode()
    return f"{meaning} ({unit})" if unit else meaning


def metrics(settings: DexNetDatabase) -> dict[str, dict[str, object]]:
    """The configuration of the grasp metrics, under the names of Dex-Net."""
    plain: dict[str, object] = {
        "quality_method": "ferrari_canny_L1",
        "quality_type": "quasi_static",
        "friction_coef": settings.quality.friction,
        "num_cone_faces": CONE_FACES,
        "torque_scaling": settings.quality.torque_scaling,
        "finger_radius": settings.quality.finger_radius,
        "soft_fingers": 1,
        "all_contacts_required": 1,
        "check_approach": 0,
    }
    samples = settings.robust.samples
    return {
        "ferrari_canny": plain,
        "robust_ferrari_canny": {
            **plain,
            "quality_type": "robust_quasi_static",
            "torque_scaling": ROBUST_TORQUE_SCALING,
            "num_quality_samples": samples,
            "sampling_snapshot_rate": samples,
            "params_uncertainty": {"sigma_friction_coef": SPREAD.friction_sigma},
            "grasp_uncertainty": _sigmas(
                "grasp", SPREAD.grasp_translation_sigma, SPREAD.grasp_rotation_sigma
            ),
            "obj_uncertainty": {
                **_sigmas("obj", SPREAD.object_translation_sigma, SPREAD.object_rotation_sigma),
                "sigma_obj_com": SPREAD.com_sigma,
            },
        },
        **{
            name: {"quality_type": "egad", "description": _meaning(GRASPS, METRICS[name])}
            for name in OWN
        },
    }


def _sigmas(of: str, translation: float, rotation: float) -> dict[str, float]:
    return {
        f"sigma_{of}_{kind}_{part}": value
        for kind, value in (("trans", translation), ("rot", rotation))
        for part in "xyz"
    }
