"""Suction grasps of a mesh: points spread evenly over its surface, with the labels of each."""

from collections import Counter

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import ArrayLike

from egad._util.arguments import check_array, check_positive
from egad._util.arrays import Flags, Floats
from egad._util.parameters import from_arguments
from egad.errors import NoGraspError, UserError, most_common
from egad.geometry import Material, RayCaster, box_sides, check_solid, mass_properties
from egad.geometry.mass import center_or_given
from egad.grasps.approach import touching_turns
from egad.grasps.grasps import vector_columns, vectors
from egad.grasps.parameters import RobustSuction, SuctionSampling
from egad.grasps.poses import hand_poses
from egad.grasps.suction.seal import Seals, seal_cups
from egad.grasps.suction.wrench import loads_in_frames, resists, robust_suction_quality
from egad.grippers import SuctionCup, cup_parts
from egad.random import generator

GRAVITY = 9.81  # m/s2
DENSITY = Material().density
CUP, ROBUST = SuctionCup(), RobustSuction()


def sample_suction(
    mesh: trimesh.Trimesh,
    cup: SuctionCup = CUP,
    n: int = 100,
    *,
    seed: int = 0,
    density: float = DENSITY,
    mass: float | None = None,
    center_of_mass: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    robust: RobustSuction = ROBUST,
) -> pd.DataFrame:
    """Sample suction grasps of a mesh, with their seal, quality and collisions.

    Points are uniform over the surface. The cup approaches each along the inward normal, turned by
    a random angle about it. All candidates are returned, sealed or not.

    Args:
        mesh: A closed mesh in metres, as it is grasped, its triangles winding outwards.
        cup: The cup.
        n: Number of grasps. The first ones do not depend on it.
        seed: The same mesh and seed give the same grasps.
        density: Density of the object, kg/m3.
        mass: Mass of the object, kg; by default that of its volume.
        center_of_mass: (3,) metres; by default that of a solid of uniform density.
        gravity: (3,) direction of gravity in the frame of the object; by default the approach of
            each grasp, as if the object hung below the cup.
        robust: Number of perturbed copies, and their spread.

    Returns:
        One row per grasp, in the frame of the mesh: `grasp`; `point_x/y/z` where the axis of the
        cup meets the surface, metres; `approach_x/y/z`, z of the cup; `axis_x/y/z`, x of the cup,
        towards the first vertex of its ring; `sealed`; `seal_failure`, why not; `strain`, the
        largest relative change of length of a spring; `resists`, whether a cup that is sealed holds
        the weight; `quality`, the share of perturbed copies that seal and hold it;
        `collision_free`, whether cup and stem approach and stay without touching the object.

    Raises:
        RejectedError: The mesh is open, bounds no volume or is not finite, or no cup seals: the
            message says why.
        UserError: It is not a mesh, or an argument is not allowed.

    Source: Mahler et al., Dex-Net 3.0, ICRA 2018. The direction of gravity is ours.
    """
    check_solid(mesh)
    settings = from_arguments(SuctionSampling, seed=seed, n=n)
    solid = mass_properties(mesh, check_positive("density", density))
    heavy = solid.mass if mass is None else check_positive("mass", mass)
    com = solid.com if center_of_mass is None else center_or_given(mesh, center_of_mass)
    caster = RayCaster(mesh)
    origins, frames = _candidates(caster, settings)
    down = frames[:, 2]
    if gravity is not None:
        given = check_array("gravity", gravity, (3,), "3 finite numbers")
        length = np.linalg.norm(given)
        if not length > 0:
            raise UserError(f"gravity is {gravity!r}; allowed: a nonzero direction")
        down = given / length
    weights = GRAVITY * heavy * down
    weights = np.broadcast_to(weights, origins.shape)
    seals = seal_cups(caster, cup, origins, frames)
    if not seals.sealed.any():
        raise NoGraspError(_why_none_seals(mesh, cup, seals))
    quality = robust_suction_quality(
        caster,
        cup,
        origins,
        frames,
        com,
        weights,
        robust=robust,
        seed=settings.seed,
        indices=np.arange(settings.n),
    )
    return pd.DataFrame(
        {
            "grasp": np.arange(settings.n),
            **vector_columns("point", origins),
            **vector_columns("approach", frames[:, 2]),
            **vector_columns("axis", frames[:, 0]),
            "sealed": seals.sealed,
            "seal_failure": seals.failures,
            "strain": seals.strains,
            "resists": _hold(cup, origins, frames, com, weights, seals),
            "quality": quality,
            "collision_free": collision_free(caster, cup, origins, frames, seals.depths),
        }
    )


def suction_poses(grasps: pd.DataFrame) -> Floats:
    """Poses (n, 4, 4) of a table of grasps: z is the approach, x towards the first vertex."""
    return hand_poses(*(vectors(grasps, name) for name in ("point", "axis", "approach")))


def collision_free(
    caster: RayCaster, cup: SuctionCup, origins: Floats, frames: Floats, depths: Floats
) -> Flags:
    """Whether each of n cups (`seal_cups`) moves in and stays without a collision above its ring.

    Mean depths of the rings (n,), metres, beyond the height of the cup count as 0.
    """
    behind = -np.where(np.abs(depths) <= cup.height, depths, 0.0)
    touching = touching_turns(caster, cup_parts(cup, cup.approach), origins, frames, behind=behind)
    return np.asarray(~touching[:, 0])


def _candidates(caster: RayCaster, settings: SuctionSampling) -> tuple[Floats, Floats]:
    """Uniform points; frames (n, 3, 3) with z inwards, which rotate with the mesh."""
    drawn = generator(settings.seed, "sample_suction").random((settings.n, 4))
    areas = np.cumsum(caster.areas)
    faces = np.searchsorted(areas, drawn[:, 0] * areas[-1], side="right")
    start, second, third = np.moveaxis(caster.triangles[faces], 1, 0)
    beyond = drawn[:, 1] + drawn[:, 2] > 1
    along = np.where(beyond[:, None], 1 - drawn[:, 1:3], drawn[:, 1:3])
    sides = second - start, third - start
    points = start + along[:, :1] * sides[0] + along[:, 1:] * sides[1]
    z = -caster.normals[faces]
    x = sides[0] / np.linalg.norm(sides[0], axis=1, keepdims=True)
    turn = 2 * np.pi * drawn[:, 3:]
    x = np.cos(turn) * x + np.sin(turn) * np.cross(z, x)
    return points, np.stack([x, np.cross(z, x), z], axis=1)


def _hold(
    cup: SuctionCup, origins: Floats, frames: Floats, com: Floats, weights: Floats, seals: Seals
) -> Flags:
    """Whether cups that are sealed hold the weight."""
    held = seals.sealed.copy()
    contacts = origins[held] + seals.depths[held, None] * frames[held, 2]
    held[held] = resists(cup, loads_in_frames(contacts, frames[held], weights[held], com))
    return held


def _why_none_seals(mesh: trimesh.Trimesh, cup: SuctionCup, seals: Seals) -> str:
    """A sentence about an object on which no cup of the candidates seals."""
    low, middle, high = 1000 * box_sides(mesh)
    width = 2000 * cup.radius
    if middle < width:
        size = f"{low:.3g} x {middle:.3g} x {high:.3g} mm"
        return f"the cup, {width:.3g} mm across, is larger than the object of {size}"
    reasons = most_common(Counter(map(str, seals.failures)))
    return f"no cup seals (of {len(seals.failures)} candidates: {reasons})"
