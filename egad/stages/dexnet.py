"""dexnet: the Dex-Net database of a dataset, with the labelled grasps of a gripper."""

import logging
from pathlib import Path

import numpy as np
import pandas as pd

from egad.errors import UserError
from egad.exchange.dexnet import MEASURES, add_dataset, add_grasps
from egad.exchange.grasps import by_object, vectors
from egad.exchange.hdf5 import check_key, copy_group, reading, writing
from egad.grasps.poses import dexnet_configurations
from egad.progress import progress
from egad.stage_settings import DexNetDatabase
from egad.tables.objects import OBJECTS

log = logging.getLogger(__name__)
METRICS = {
    "ferrari_canny": "quality",
    "robust_ferrari_canny": "robust_quality",
    "held": "held",
    "collision_free": "collision_free",
}
COLUMNS = [
    *(f"{name}_{part}" for name in ("center", "axis", "approach") for part in "xyz"),
    *METRICS.values(),
]


def run(
    settings: DexNetDatabase,
    dataset: str,
    gripper: str,
    parts: list[Path],
    grasps: Path,
    out: Path,
) -> None:
    """Bring the objects of all shards together and add their grasps.

    Args:
        settings: What this stage reads.
        dataset: Name of the dataset.
        gripper: Name of the gripper.
        parts: The objects, as `stages.dexnet_objects` writes them.
        grasps: Table with the columns of `tables.grasping.GRASPS`, sorted by label.
        out: The database. Objects without grasps are in it, too.
    """
    homes = {key: part for part in parts for key in _keys(part)}
    found = by_object(grasps, COLUMNS)
    label, rows = next(found, ("", None))
    with writing(out) as file:
        objects = add_dataset(file, check_key(dataset), metrics(settings), _meanings())
        for key in progress(sorted(homes), "writing grasps", len(homes)):
            with reading(homes[key]) as part:
                copy_group(part["objects"][key], objects.create_group(key))
            configurations, values = _grasps(settings, rows if label == key else None)
            add_grasps(objects[key], check_key(gripper), configurations, values)
            if label == key:
                label, rows = next(found, ("", None))
        if rows is not None:
            raise UserError(f"{grasps}: object {label!r} is none of those that were written")
    log.info("%d objects", len(homes))


def _keys(part: Path) -> list[str]:
    with reading(part) as file:
        return list(file["objects"])


def _grasps(
    settings: DexNetDatabase, rows: pd.DataFrame | None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    if rows is None:
        return np.empty((0, 10)), {}
    centers, axes, approaches = (vectors(rows, name) for name in ("center", "axis", "approach"))
    opening = settings.gripper.opening
    configurations = dexnet_configurations(centers, axes, approaches, opening)
    values = {name: rows[column].to_numpy(dtype=float) for name, column in METRICS.items()}
    return configurations, values


def _meanings() -> dict[str, str]:
    return {name: OBJECTS.field(name).metadata[b"meaning"].decode() for name in MEASURES}


def metrics(settings: DexNetDatabase) -> dict[str, dict[str, object]]:
    """How the metrics of the grasps are computed, under the names that Dex-Net has for it."""
    plain: dict[str, object] = {
        "quality_method": "ferrari_canny_L1",
        "quality_type": "quasi_static",
        "friction_coef": settings.quality.friction,
        "num_cone_faces": settings.quality.cone_faces,
        "torque_scaling": settings.quality.torque_scaling,
        "finger_radius": settings.quality.finger_radius,
        "soft_fingers": 1,
        "all_contacts_required": 1,
    }
    robust = settings.robust
    return {
        "ferrari_canny": plain,
        "robust_ferrari_canny": {
            **plain,
            "quality_type": "robust_quasi_static",
            "torque_scaling": robust.torque_scaling,
            "num_quality_samples": robust.samples,
            "sigma_friction_coef": robust.friction_sigma,
            "grasp_uncertainty": _sigmas(
                "grasp", robust.grasp_translation_sigma, robust.grasp_rotation_sigma
            ),
            "obj_uncertainty": {
                **_sigmas("obj", robust.object_translation_sigma, robust.object_rotation_sigma),
                "sigma_obj_com": robust.com_sigma,
            },
        },
        "held": {
            "quality_type": "egad",
            "description": "fraction of the disturbed copies with positive quality",
        },
        "collision_free": {
            "quality_type": "egad",
            "description": "whether the hand fits at the approach angle of the grasp",
        },
    }


def _sigmas(of: str, translation: float, rotation: float) -> dict[str, float]:
    return {
        f"sigma_{of}_{kind}_{part}": value
        for kind, value in (("trans", translation), ("rot", rotation))
        for part in "xyz"
    }
