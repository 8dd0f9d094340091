"""Suction grasps in the columns of labelled grasps."""

import numpy as np
import pandas as pd

from egad._util.arrays import Floats
from egad.geometry import RayCaster
from egad.grasps import posed_table
from egad.grippers import SuctionCup
from egad.suction.sampler import collision_free
from egad.suction.seal import seal_cups


def label_cups(
    caster: RayCaster, cup: SuctionCup, poses: Floats, quality: Floats, *, is_rate: bool
) -> pd.DataFrame:
    """Label suction grasps that are given as poses.

    Args:
        caster: Ray caster of the object, closed, metres.
        cup: The cup.
        poses: (n, 4, 4) poses of the cup, see `suction_poses`, metres.
        quality: (n,) not negative.
        is_rate: Whether the quality is the share of perturbed copies that hold.

    Returns:
        Columns of `tables.grasping.GRASPS` without `id` and `label`. Both contacts are the origin
        of the pose, both normals the opposite of the approach; the width is 0. Deviation and
        success rate are missing if the quality is not a rate.
    """
    origins, frames = poses[:, :3, 3], np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))
    depths = seal_cups(caster, cup, origins, frames).depths
    standing = cup.model_copy(update={"approach": 0.0})
    fits, free = (collision_free(caster, each, origins, frames, depths) for each in (standing, cup))
    table = posed_table(
        origins,
        frames,
        contacts=np.stack([origins] * 2, axis=1),
        normals=np.stack([-frames[:, 2]] * 2, axis=1),
        quality=quality,
        fits=fits,
        free=free,
    )
    if not is_rate:
        return table
    deviation = np.sqrt(quality * (1 - quality))
    return table.assign(robust_quality_std=deviation, robust_success_rate=quality)
