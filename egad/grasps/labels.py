"""Labelled grasps of an object: what is known about each of them, as a table."""

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.grasps.gripper import collision_free
from egad.grasps.quality import ferrari_canny
from egad.grasps.robust import robust_ferrari_canny
from egad.grasps.sampler import sample
from egad.stage_settings import GraspLabels

Floats = NDArray[np.float64]


def label(
    mesh: trimesh.Trimesh, com: Floats, settings: GraspLabels, rng: np.random.Generator
) -> pd.DataFrame:
    """Sample grasps of an object and rate them.

    Args:
        mesh: The object as it is grasped, metres, its triangles winding outwards.
        com: (3,) centre of mass, metres.
        settings: The gripper, how many grasps, and how to rate them.
        rng: Where chance comes from.

    Returns:
        A row a grasp, with the columns of `tables.grasping.GRASPS` but for `id` and `label`, in the
        frame of the mesh.

    Raises:
        RejectedError: There is no grasp; the reason says what became of the candidates.
    """
    opening = settings.gripper.opening
    grasps, tally = sample(mesh, opening, settings.grasp_label.grasps, settings.sampling, rng)
    if len(grasps) == 0:
        raise RejectedError(f"no grasp ({tally})")
    quality = ferrari_canny(
        grasps.points, grasps.normals, grasps.axes, com, **settings.quality.model_dump()
    )
    mean, deviation, held = robust_ferrari_canny(
        mesh, grasps, com, opening, quality=settings.quality, robust=settings.robust, rng=rng
    )
    approach, free = collision_free(mesh, grasps, settings.gripper)
    return pd.DataFrame(
        {
            "grasp": np.arange(len(grasps)),
            **_columns("center", grasps.centers),
            **_columns("axis", grasps.axes),
            **_columns("approach", approach),
            "width": grasps.widths,
            **_columns("contact0", grasps.points[:, 0]),
            **_columns("contact1", grasps.points[:, 1]),
            **_columns("normal0", grasps.normals[:, 0]),
            **_columns("normal1", grasps.normals[:, 1]),
            "quality": quality,
            "robust_quality": mean,
            "robust_quality_std": deviation,
            "held": held,
            "collision_free": free,
        }
    )


def _columns(name: str, vectors: Floats) -> dict[str, Floats]:
    return {f"{name}_{part}": vectors[:, i] for i, part in enumerate("xyz")}
