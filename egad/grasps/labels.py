"""Labelled grasps of an object: what is known about each of them, as a table."""

from dataclasses import asdict

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad._util.parameters import from_arguments
from egad.errors import RejectedError
from egad.geometry import RayCaster, check_solid
from egad.geometry.surfaces import FRICTION
from egad.grasps.antipodal import ContactPairs, SamplingStatistics, sample_contacts
from egad.grasps.approach import best_approaches
from egad.grasps.jaws import JawFaces
from egad.grasps.opening import needed_openings
from egad.grasps.parameters import (
    APPROACH_ANGLES,
    CONE,
    GraspLabel,
    LabelParameters,
    Quality,
    Robust,
    Sampling,
)
from egad.grasps.quality import ferrari_canny
from egad.grasps.robust import robust_ferrari_canny
from egad.grippers import Gripper, HandBody


def label_parameters(
    gripper: Gripper,
    grasps: int,
    seed: int,
    *,
    friction: float = FRICTION,
    cone: float = CONE,
    approach_angles: int = APPROACH_ANGLES,
) -> LabelParameters:
    """The default parameters of labelled grasps, overridden by the given ones.

    Raises:
        UserError: A value is not allowed.
    """
    return from_arguments(
        LabelParameters,
        seed=seed,
        gripper=gripper,
        grasp_label=from_arguments(GraspLabel, grasps=grasps, approach_angles=approach_angles),
        sampling=from_arguments(Sampling, cone=cone),
        quality=from_arguments(Quality, friction=friction),
        robust=Robust(),
    )


def label_grasps(
    mesh: trimesh.Trimesh,
    com: Floats,
    settings: LabelParameters,
    rng: np.random.Generator,
    body: HandBody,
) -> pd.DataFrame:
    """Sample grasps of an object and rate them.

    Args:
        mesh: The object as it is grasped, closed, metres, its triangles winding outwards.
        com: (3,) center of mass, metres.
        settings: The gripper, how many grasps, and how to rate them.
        rng: Random number generator.
        body: Body of the gripper's hand.

    Returns:
        One row per grasp, in the frame of the mesh, with the columns of `tables.grasping.GRASPS`
        except `id` and `label`.

    Raises:
        RejectedError: No grasp was found; the reason says at which tests the candidates failed. Or
            the mesh is open, bounds no volume or is not finite.
        UserError: It is not a mesh.
    """
    check_solid(mesh)
    caster = RayCaster(mesh)
    grasps, statistics = sample_for_labels(caster, settings, rng)
    if len(grasps) == 0:
        raise RejectedError(f"no grasp ({statistics})")
    return rate_grasps(caster, com, grasps, settings, rng, body)


def sample_for_labels(
    caster: RayCaster, settings: LabelParameters, rng: np.random.Generator
) -> tuple[ContactPairs, SamplingStatistics]:
    """Sample the grasps of an object to be rated; also returns the sampling statistics.

    The sampler's own test of one horizontal approach is skipped: the body of the hand is tested
    from all around instead.
    """
    wanted, opening = settings.grasp_label.grasps, settings.gripper.opening
    sampling = settings.sampling.model_copy(update={"approach_clearance": 0.0})
    return sample_contacts(caster, opening, wanted, sampling, rng)


def rate_grasps(
    caster: RayCaster,
    com: Floats,
    grasps: ContactPairs,
    settings: LabelParameters,
    rng: np.random.Generator,
    body: HandBody,
) -> pd.DataFrame:
    """Rate grasps: arguments and result are those of `label_grasps`, with a caster of the mesh."""
    gripper, wanted = settings.gripper, settings.grasp_label
    approach = best_approaches(
        caster, grasps, body, angles=wanted.approach_angles, way=wanted.approach_way
    )
    needed = needed_openings(caster, grasps, approach.directions, body)
    faces = JawFaces.of(body, grasps, approach.directions, needed)
    quality = ferrari_canny(
        grasps.points, grasps.normals, grasps.axes, com, **settings.quality.model_dump()
    )
    if faces is not None:
        fitting = ferrari_canny(
            grasps.points, faces.normals(grasps), grasps.axes, com, **settings.quality.model_dump()
        )
        quality = np.minimum(quality, fitting)
    mean, deviation, held = robust_ferrari_canny(
        caster,
        grasps,
        com,
        gripper.opening,
        quality=settings.quality,
        robust=settings.robust,
        rng=rng,
        faces=faces,
    )
    return pd.DataFrame(
        {
            "grasp": np.arange(len(grasps)),
            **_columns("center", grasps.centers),
            **_columns("axis", grasps.axes),
            **_columns("approach", approach.directions),
            "width": grasps.widths,
            # a hand that fits is slightly wider than its opening, see `hand.CLEARANCE`
            "needed_opening": np.where(approach.fits, np.minimum(needed, gripper.opening), needed),
            **_columns("contact0", grasps.points[:, 0]),
            **_columns("contact1", grasps.points[:, 1]),
            **_columns("normal0", grasps.normals[:, 0]),
            **_columns("normal1", grasps.normals[:, 1]),
            "quality": quality,
            "robust_quality": mean,
            "robust_quality_std": deviation,
            "robust_success_rate": held,
            "fits": approach.fits,
            "collision_free": approach.free,
            "angles_fit": approach.angles_fit,
            "angles_collision_free": approach.angles_collision_free,
        }
    )


def statistics_row(
    wanted: int, statistics: SamplingStatistics, grasps: pd.DataFrame
) -> dict[str, int]:
    """Sampling statistics of an object: a row of `tables.grasping.SAMPLING`.

    Args:
        wanted: Number of grasps wanted.
        statistics: Sampling statistics.
        grasps: The rated grasps, with the columns of `tables.grasping.GRASPS`; may be empty.
    """
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


def _columns(name: str, vectors: Floats) -> dict[str, Floats]:
    return {f"{name}_{part}": vectors[:, i] for i, part in enumerate("xyz")}
