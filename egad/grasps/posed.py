"""Labels of grasps that are given as poses: what their fingers touch, and their collisions."""

import numpy as np
import pandas as pd

from egad._util.arrays import Flags, Floats
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs
from egad.grasps.approach import touching_turns
from egad.grasps.opening import needed_openings
from egad.grasps.samplers import Sampled
from egad.grasps.suction import collision_free, seal_cups
from egad.grippers import SUCTION, HandBody, cup_of
from egad.grippers.kinds import CupKind, JawKind
from egad.tables.columns import vector_names


def label_poses(caster: RayCaster, grasps: Sampled, body: HandBody, way: float) -> pd.DataFrame:
    """Label grasps of jaws: columns of `tables.grasping.GRASPS` but `id` and `label`.

    The normals are those where rays from the open fingers along the closing axis meet the surface;
    they are missing if the rays meet none. The `way` in is straight, metres. The robust quality is
    the given one; its deviation and the success rate are missing.
    """
    widths, (centers, frames) = grasps.widths, _frames(grasps.poses)
    axes, approaches = frames[:, 0], frames[:, 2]
    opening = body.gripper.opening
    half = widths[:, None] / 2 * axes
    points = np.stack([centers - half, centers + half], axis=1)
    ends = [_normals(caster, centers, side * axes, opening / 2) for side in (-1, 1)]
    pairs = ContactPairs(points, np.stack(ends, axis=1), axes)
    behind = body.reach(widths) - body.reach(np.array([opening]))
    there, coming = (
        touching_turns(caster, body.parts(back), centers, frames, behind=behind)[:, 0]
        for back in (0, way)
    )
    return posed_table(
        centers,
        frames,
        contacts=points,
        normals=pairs.normals,
        quality=grasps.quality,
        fits=~there,
        free=~(there | coming),
    ).assign(width=widths, needed_opening=needed_openings(caster, pairs, approaches, body))


def posed_table(
    centers: Floats,
    frames: Floats,
    *,
    contacts: Floats,
    normals: Floats,
    quality: Floats,
    fits: Flags,
    free: Flags,
) -> pd.DataFrame:
    """Columns of `tables.grasping.GRASPS` of n grasps that have one approach each.

    Rows of the frames are the unit vectors x, y, z of the hand. The quality is the nominal and the
    robust one; width and needed opening are 0, deviation and success rate are missing.
    """
    vectors = {
        "center": centers,
        "axis": frames[:, 0],
        "approach": frames[:, 2],
        **{f"contact{side}": contacts[:, side] for side in (0, 1)},
        **{f"normal{side}": normals[:, side] for side in (0, 1)},
    }
    columns = [pd.DataFrame(each, columns=vector_names(name)) for name, each in vectors.items()]
    return pd.concat(columns, axis=1).assign(
        grasp=np.arange(len(centers)),
        width=0.0,
        needed_opening=0.0,
        quality=quality,
        robust_quality=quality,
        robust_quality_std=np.nan,
        robust_success_rate=np.nan,
        fits=fits,
        collision_free=free,
        angles_fit=fits.astype(int),
        angles_collision_free=free.astype(int),
    )


def _normals(caster: RayCaster, centers: Floats, outwards: Floats, reach: float) -> Floats:
    """Outward normals where fingers come in from both ends of the opening, (n, 3); or NaN."""
    hits = caster.first_hits(centers + reach * outwards, -outwards)
    met = hits.entering & (hits.distances < 2 * reach)
    return np.where(met[:, None], hits.normals, np.nan)


def label_cups(caster: RayCaster, grasps: Sampled, body: HandBody, _way: float) -> pd.DataFrame:
    """Label suction grasps, with columns as of `label_poses`.

    Both contacts are the origin of the pose, both normals the opposite of the approach; the width
    is 0. Deviation and success rate are missing unless the quality is the share of perturbed copies
    that hold.
    """
    cup, quality = cup_of(body.gripper, "a suction grasp"), grasps.quality
    origins, frames = _frames(grasps.poses)
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
    if body.gripper.grasps_with != SUCTION:
        return table
    deviation = np.sqrt(quality * (1 - quality))
    return table.assign(robust_quality_std=deviation, robust_success_rate=quality)


def _frames(poses: Floats) -> tuple[Floats, Floats]:
    """Origins (n, 3) of poses, and their unit vectors in rows, (n, 3, 3)."""
    return poses[:, :3, 3], np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))


# how grasps of each kind of gripper are labelled that are not sampled here
LABELS = {JawKind.name: label_poses, CupKind.name: label_cups}
