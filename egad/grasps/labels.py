"""Labelled grasps of an object: what is known about each of them, as a table."""

from dataclasses import asdict

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from egad._util.arrays import Flags, Floats
from egad._util.parameters import from_arguments
from egad.friction import FRICTION
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs, SamplingStatistics, sample_contacts
from egad.grasps.approach import best_approaches, touching_turns
from egad.grasps.grasps import vector_columns
from egad.grasps.opening import needed_openings
from egad.grasps.parameters import (
    APPROACH_ANGLES,
    APPROACH_WAY,
    CONE,
    GraspLabel,
    LabelParameters,
    Quality,
    Robust,
    Sampling,
)
from egad.grasps.quality import ferrari_canny
from egad.grasps.robust import JawFaces, close_fingers, robust_ferrari_canny
from egad.grasps.samplers import Sampled
from egad.grasps.suction import collision_free, seal_cups
from egad.grippers import SUCTION, Gripper, HandBody, cup_of
from egad.grippers.kinds import CupKind, JawKind
from egad.tables.grasping import GRASPS

COLUMNS = [name for name in GRASPS.names if name not in ("id", "label")]


def label_parameters(
    gripper: Gripper,
    grasps: int,
    seed: int,
    *,
    friction: float = FRICTION,
    cone: float = CONE,
    approach_angles: int = APPROACH_ANGLES,
) -> LabelParameters:
    """The default parameters of labelled grasps, overridden by the given ones; or `UserError`."""
    return from_arguments(
        LabelParameters,
        seed=seed,
        gripper=gripper,
        grasp_label=from_arguments(GraspLabel, grasps=grasps, approach_angles=approach_angles),
        sampling=from_arguments(Sampling, cone=cone),
        quality=from_arguments(Quality, friction=friction),
        robust=Robust(),
    )


def sample_for_labels(
    caster: RayCaster, settings: LabelParameters, rng: np.random.Generator
) -> tuple[ContactPairs, SamplingStatistics]:
    """Sample grasps to be rated, without the sampler's own test of one approach; statistics."""
    wanted, opening = settings.grasp_label.grasps, settings.gripper.opening
    return sample_contacts(caster, opening, wanted, settings.sampling, rng, clearance=0.0)


def rate_grasps(
    caster: RayCaster,
    com: Floats,
    grasps: ContactPairs,
    settings: LabelParameters,
    rng: np.random.Generator,
    body: HandBody,
) -> pd.DataFrame:
    """Rate grasps of a solid about its center of mass (3,), metres: `GRASPS` but `id`, `label`."""
    angles, opening = settings.grasp_label.approach_angles, settings.gripper.opening
    approach = best_approaches(caster, grasps, body, angles=angles, way=APPROACH_WAY)
    needed = needed_openings(caster, grasps, approach.directions, body)
    faces = JawFaces.of(body, grasps, approach.directions, needed)
    return _table(
        grasps.centers,
        grasps.axes,
        approach.directions,
        grasps.points,
        grasps.normals,
        width=grasps.widths,
        # a hand that fits is slightly wider than its opening, see `hand.CLEARANCE`
        needed_opening=np.where(approach.fits, np.minimum(needed, opening), needed),
        **_qualities(caster, com, grasps, faces, settings, rng),
        fits=approach.fits,
        collision_free=approach.free,
        angles_fit=approach.angles_fit,
        angles_collision_free=approach.angles_collision_free,
    )


def _qualities(
    caster: RayCaster,
    com: Floats,
    grasps: ContactPairs,
    faces: JawFaces | None,
    settings: LabelParameters,
    rng: np.random.Generator,
) -> dict[str, Floats]:
    """The qualities of grasps by column; with `faces`, the lower one against object and jaws."""
    normals = [grasps.normals] if faces is None else [grasps.normals, faces.normals(grasps)]
    quality = settings.quality.model_dump()
    values = [ferrari_canny(grasps.points, each, grasps.axes, com, **quality) for each in normals]
    robust = robust_ferrari_canny(
        caster,
        grasps,
        com,
        settings.gripper.opening,
        quality=settings.quality,
        robust=settings.robust,
        rng=rng,
        faces=faces,
    )
    names = ("quality", "robust_quality", "robust_quality_std", "robust_success_rate")
    return dict(zip(names, [np.min(values, axis=0), *robust], strict=True))


def _table(
    centers: Floats,
    axes: Floats,
    approaches: Floats,
    contacts: Floats,
    normals: Floats,
    **columns: ArrayLike,
) -> pd.DataFrame:
    """Grasps in the columns of `GRASPS`, from vectors of n grasps and the other columns."""
    vectors = {"center": centers, "axis": axes, "approach": approaches}
    for side in (0, 1):
        vectors |= {f"contact{side}": contacts[:, side], f"normal{side}": normals[:, side]}
    for name, values in vectors.items():
        columns |= vector_columns(name, values)
    return pd.DataFrame({"grasp": np.arange(len(centers)), **columns})[COLUMNS]


def _rated(quality: Floats, fits: Flags, free: Flags) -> dict[str, ArrayLike]:
    """Columns of unperturbed grasps with their one approach; a cup is 0 wide."""
    return {
        "width": 0.0,
        "needed_opening": 0.0,
        "quality": quality,
        "robust_quality": quality,
        "robust_quality_std": np.nan,
        "robust_success_rate": np.nan,
        "fits": fits,
        "collision_free": free,
        "angles_fit": fits.astype(int),
        "angles_collision_free": free.astype(int),
    }


def statistics_row(
    wanted: int, statistics: SamplingStatistics, grasps: pd.DataFrame
) -> dict[str, int]:
    """A row of `tables.grasping.SAMPLING` about an object, from its rated grasps, if any."""
    failed = asdict(statistics)
    candidates = failed.pop("candidates")
    fits, free = (grasps[name].to_numpy(bool) for name in ("fits", "collision_free"))
    return {
        "n_wanted": wanted,
        "n_candidates": candidates,
        **{f"n_{name}": count for name, count in failed.items()},
        "n_surplus": candidates - sum(failed.values()) - len(grasps),
        "n_grasps": len(grasps),
        "n_slipping": int((grasps["quality"] == 0).sum()),
        "n_in_collision": int(np.sum(~fits)),
        "n_unreachable": int(np.sum(fits & ~free)),
    }


def label_poses(caster: RayCaster, grasps: Sampled, body: HandBody, way: float) -> pd.DataFrame:
    """Label grasps of jaws (`GRASPS` but `id`, `label`), with normals where open fingers meet."""
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
    rated = _rated(grasps.quality, ~there, ~(there | coming))
    needed = needed_openings(caster, pairs, approaches, body)
    rated |= {"width": widths, "needed_opening": needed}
    return _table(centers, axes, approaches, points, pairs.normals, **rated)


def label_at_poses(
    caster: RayCaster,
    com: Floats,
    poses: Floats,
    widths: Floats,
    settings: LabelParameters,
    rng: np.random.Generator,
    body: HandBody,
) -> pd.DataFrame:
    """Rate grasps at poses (n, 4, 4), as `rate_grasps`; a NaN of `widths` (n,) is measured.

    A grasp that touches nothing has quality 0; if its width is not known, it is the opening.
    """
    centers, frames = _frames(poses)
    axes, approaches = frames[:, 0], frames[:, 2]
    opening = body.gripper.opening
    pairs, touching = close_fingers(caster, centers, axes, opening)
    measured = np.where(touching, pairs.widths, opening)
    sampled = Sampled(poses, np.where(np.isnan(widths), measured, widths), np.zeros(len(poses)))
    table = label_poses(caster, sampled, body, APPROACH_WAY)
    rated, needed = pairs.take(np.flatnonzero(touching)), table["needed_opening"].to_numpy()
    faces = JawFaces.of(body, rated, approaches[touching], needed[touching])
    columns = _qualities(caster, com, rated, faces, settings, rng)
    table[list(columns)] = 0.0
    for side in (0, 1):
        columns |= vector_columns(f"contact{side}", rated.points[:, side])
        columns |= vector_columns(f"normal{side}", rated.normals[:, side])
    table.loc[touching, list(columns)] = np.stack(list(columns.values()), axis=1)
    return table


def _normals(caster: RayCaster, centers: Floats, outwards: Floats, reach: float) -> Floats:
    """Outward normals where fingers come in from both ends of the opening, (n, 3); or NaN."""
    hits = caster.first_hits(centers + reach * outwards, -outwards)
    met = hits.entering & (hits.distances < 2 * reach)
    return np.where(met[:, None], hits.normals, np.nan)


def label_cups(caster: RayCaster, grasps: Sampled, body: HandBody, _way: float) -> pd.DataFrame:
    """Label suction grasps as `label_poses`; both contacts are the origin of the pose."""
    cup, quality = cup_of(body.gripper, "a suction grasp"), grasps.quality
    origins, frames = _frames(grasps.poses)
    depths = seal_cups(caster, cup, origins, frames).depths
    standing = cup.model_copy(update={"approach": 0.0})
    fits, free = (collision_free(caster, each, origins, frames, depths) for each in (standing, cup))
    axes, approaches = frames[:, 0], frames[:, 2]
    contacts, normals = np.stack([origins] * 2, axis=1), np.stack([-approaches] * 2, axis=1)
    rated = _rated(quality, fits, free)
    table = _table(origins, axes, approaches, contacts, normals, **rated)
    if body.gripper.grasps_with != SUCTION:
        return table
    deviation = np.sqrt(quality * (1 - quality))
    return table.assign(robust_quality_std=deviation, robust_success_rate=quality)


def _frames(poses: Floats) -> tuple[Floats, Floats]:
    """Origins (n, 3) of poses, and their unit vectors in rows, (n, 3, 3)."""
    return poses[:, :3, 3], np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))


# how grasps of each kind of gripper are labelled that are not sampled here
LABELS = {JawKind.name: label_poses, CupKind.name: label_cups}
