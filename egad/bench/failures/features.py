"""The shape of objects where a detector fails and where it succeeds, as a few measured features.

The features of an object are computed from its surface, and from the grasps that held it in the
search: where and how the hand touched it, whoever proposed them.
"""

import math
import warnings
from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats, Ints
from egad.bench.failures.reference import read_attempt
from egad.bench.stats import Interval, bootstrap, wilson
from egad.detectors import Grasp
from egad.geometry import Material, RayCaster, mass_properties
from egad.grippers import Gripper
from egad.grippers.kinds import CupKind, JawKind
from egad.random import generator
from egad.sim import principal_frame
from egad.tables import parquet

POINTS = 20_000  # on a surface, or in a box
THIN = 0.1  # quantile of the thickness over the surface
NEAR = 0.005  # metres: surface around a contact
MAX_GRASPS = 12  # of an object: the first that held it
LINES = 7  # rays along each side of a finger pad
OPPOSITE = -0.5  # cosine: surface turned further away is the other side of a wall
SKIN = 1e-6  # metres under the surface, where rays begin
ABOVE = 0.02  # metres from a suction cup to where rays begin
TAIL = 0.05  # fraction of the objects that the detector solves beyond either end of their range
RANGE = (TAIL, 1 - TAIL)


class ShapeFeature(NamedTuple):
    """A feature, in words."""

    title: str
    unit: str  # unit of the number as shown; empty if it has none
    factor: float  # from the number in tables to the one shown
    meaning: str


SHAPE_FEATURES = {
    "grasp_size": ShapeFeature(
        "size in the hand",
        "% of the opening",
        100,
        "distance of the two contacts, as a share of the opening of the hand",
    ),
    "wall_thickness": ShapeFeature(
        "wall thickness",
        "mm",
        1000,
        "thickness that 90 % of the surface exceeds, along the inward normal",
    ),
    "contact_curvature": ShapeFeature(
        "curvature at the grasp",
        "1/cm",
        0.01,
        "1 / radius of the ball on which normals within 5 mm of a contact spread as much",
    ),
    "concavity": ShapeFeature(
        "concavity", "%", 100, "share of the convex hull that the object does not fill"
    ),
    "asymmetry": ShapeFeature(
        "asymmetry",
        "%",
        100,
        "share of the volume whose mirror image lies outside, in the best of the three planes "
        "through the principal axes",
    ),
    "complexity": ShapeFeature(
        "shape complexity", "bit", 1, "entropy of the angular deficits, as on the map"
    ),
    "graspability": ShapeFeature(
        "graspability",
        "\N{MULTIPLICATION SIGN}10\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT THREE}",
        1000,
        "grasp quality that a quarter of the sampled grasps exceed, as on the map; high is easy",
    ),
}


def shape_features(
    mesh: trimesh.Trimesh, attempts: pd.DataFrame, gripper: Gripper
) -> dict[str, float]:
    """`SHAPE_FEATURES` but those of the map; metres, 1/m.

    The mesh is closed and scaled. Those of grasps are medians over the first twelve that held; NaN
    without any. A cup has one contact, and so no `grasp_size`.
    """
    caster = RayCaster(mesh)
    points, faces = trimesh.sample.sample_surface(mesh, POINTS, seed=0)
    normals = caster.normals[faces]
    sizes, curvatures = [], []
    for grasp in held_grasps(mesh, attempts):
        contacts = contact_points(caster, grasp, gripper)
        if len(contacts) == 2:
            sizes.append(math.dist(*contacts) / gripper.opening)
        curvatures += [patch_curvature(points, normals, contact) for contact in contacts]
    return {
        "grasp_size": float(pd.Series(sizes, dtype=float).median()),
        "wall_thickness": wall_thickness(caster, points, normals),
        "contact_curvature": float(pd.Series(curvatures, dtype=float).median()),
        "concavity": concavity(mesh),
        "asymmetry": asymmetry(mesh),
    }


def held_grasps(mesh: trimesh.Trimesh, attempts: pd.DataFrame) -> list[Grasp]:
    """The first grasps that held an object, in the frame of its mesh."""
    to_mesh = np.linalg.inv(principal_frame(mass_properties(mesh, Material().density))[1])
    found = []
    for row in parquet.records(attempts[attempts["success"]].head(MAX_GRASPS)):
        rest, grasp = read_attempt(row)
        found.append(grasp.moved(to_mesh @ np.linalg.inv(rest.matrix)))
    return found


def contact_points(caster: RayCaster, grasp: Grasp, gripper: Gripper) -> Floats:
    """Where fingers, (2, 3), or cup, (1, 3), first meet an object, metres; (0, 3) if one misses."""
    rays = RAYS[gripper.kind.name](gripper, grasp.width)
    sides = [_first_contact(caster, grasp.pose, *each) for each in rays]
    met = [side for side in sides if side is not None]
    return np.array(met if len(met) == len(sides) else []).reshape(-1, 3)


def _rays_of_jaws(gripper: Gripper, width: float) -> list[tuple[Floats, Floats]]:
    """Where rays from both pads start, and their direction, in the frame of the hand."""
    half, reach = gripper.finger_width / 2, gripper.kind.span[1]
    across = np.linspace(-half, half, LINES)
    along = np.linspace(-reach, reach, LINES)
    y, z = (grid.ravel() for grid in np.meshgrid(across, along))
    return [
        (np.stack([np.full_like(y, side * width / 2), y, z], axis=1), np.array([-side, 0.0, 0.0]))
        for side in (-1.0, 1.0)
    ]


def _ray_of_cup(_gripper: Gripper, _width: float) -> list[tuple[Floats, Floats]]:
    """The same for the axis of a cup."""
    return [(np.array([[0.0, 0.0, -ABOVE]]), np.array([0.0, 0.0, 1.0]))]


RAYS = {JawKind.name: _rays_of_jaws, CupKind.name: _ray_of_cup}


def _first_contact(
    caster: RayCaster, pose: Floats, starts: Floats, direction: Floats
) -> Floats | None:
    """The nearest point that parallel rays hit, (3,); rays are given in the frame of the hand."""
    origins = starts @ pose[:3, :3].T + pose[:3, 3]
    along = pose[:3, :3] @ direction
    distances = caster.first_hits(origins, np.broadcast_to(along, origins.shape)).distances
    first = int(distances.argmin())
    if not np.isfinite(distances[first]):
        return None
    met: Floats = origins[first] + distances[first] * along
    return met


def patch_curvature(points: Floats, normals: Floats, contact: Floats) -> float:
    """1 / radius (1/m) of the ball that a surface resembles around a contact; 0 on a plane.

    On a large ball, the mean angle between the normals within 5 mm and their mean is 2/3 of 5 mm
    over the radius. Parts of the surface turned by more than 120 degrees from the nearest point,
    such as the other side of a wall, do not count. NaN if none of the n points, spread evenly over
    the surface, is near.
    """
    away = np.linalg.norm(points - contact, axis=1)
    closest = int(away.argmin())
    patch = normals[(away <= NEAR) & (normals @ normals[closest] > OPPOSITE)]
    if not len(patch):
        return float("nan")
    mean = patch.mean(axis=0)
    angles = np.arccos(np.clip(patch @ (mean / np.linalg.norm(mean)), -1, 1))
    return float(1.5 * angles.mean() / NEAR)


def wall_thickness(caster: RayCaster, points: Floats, normals: Floats) -> float:
    """Thickness (m) along the inward normal that 90 % of n evenly spread points, (n, 3), exceed."""
    hits = caster.first_hits(points - SKIN * normals, -normals)
    found = hits.distances[np.isfinite(hits.distances)] + SKIN
    return float(np.quantile(found, THIN)) if len(found) else float("nan")


def concavity(mesh: trimesh.Trimesh) -> float:
    """Share of its convex hull that a solid does not fill, 0 to 1."""
    return float(max(1 - mesh.volume / mesh.convex_hull.volume, 0.0))


def asymmetry(mesh: trimesh.Trimesh) -> float:
    """Share of a solid whose mirror image lies outside, for the best of its principal planes."""
    _, to_principal = principal_frame(mass_properties(mesh, Material().density))
    caster = RayCaster(mesh.copy().apply_transform(to_principal))
    low, high = np.asarray(caster.mesh.bounds)
    points = generator(0, "asymmetry").uniform(low, high, size=(POINTS, 3))
    inside = points[caster.contains(points)]
    if not len(inside):
        return float("nan")
    mirrors = np.ones((3, 3)) - 2 * np.eye(3)
    return float(min(1 - caster.contains(inside * mirror).mean() for mirror in mirrors))


class ExplainedShare(NamedTuple):
    """How a feature distinguishes failures from objects that the detector solves."""

    low: float  # quantile 5 % of the feature over the solved objects
    high: float  # quantile 95 %
    below: float  # share of the failures below the range from low to high
    above: float  # share of the failures above
    # share of the failures that the feature explains: those outside the range, minus the 10 %
    # of solved objects that also lie there. It may be negative
    value: float
    ci_low: float  # lower end of its 95 % interval for other objects of the same kind
    ci_high: float  # upper end


def shares(failures: pd.DataFrame, solved: pd.DataFrame) -> dict[str, ExplainedShare]:
    """For each feature known of a failure and two solved objects, the share that it explains.

    It explains a failure if few solved objects have such a value. The shares are associations, not
    causes, and overlap: a thin object may also be concave.
    """
    found = {}
    for name in failures:
        inner, outer = (table[name].dropna().to_numpy(float) for table in (solved, failures))
        if len(outer) and len(inner) > 1:
            found[str(name)] = _share(outer, inner)
    return found


def _share(failures: Floats, solved: Floats) -> ExplainedShare:
    low, high = np.quantile(solved, RANGE)
    below, above = (failures < low).mean(), (failures > high).mean()
    outside = int(((failures < low) | (failures > high)).sum())
    value, interval = below + above - 2 * TAIL, _interval(failures, solved, outside)
    return ExplainedShare._make(map(float, (low, high, below, above, value, *interval)))


def _interval(failures: Floats, solved: Floats, outside: int) -> Interval:
    """Bootstrap interval of a share, at least Wilson's, as few failures may agree by chance."""
    values = np.concatenate([failures, solved])
    is_failure = np.arange(len(values)) < len(failures)

    def statistic(drawn: Ints) -> Floats:
        of_failure, value = is_failure[drawn], values[drawn]
        with warnings.catch_warnings():  # a draw may have no solved objects
            warnings.simplefilter("ignore", RuntimeWarning)
            low, high = np.nanquantile(np.where(of_failure, np.nan, value), RANGE, axis=1)
        beyond = of_failure & ((value < low[:, None]) | (value > high[:, None]))
        with np.errstate(invalid="ignore"):  # a draw may have no failures
            found: Floats = beyond.sum(axis=1) / of_failure.sum(axis=1) - 2 * TAIL
        return np.where(np.isnan(low), np.nan, found)

    low, high = bootstrap(statistic, len(values))
    least, most = wilson(outside, len(failures))
    return float(np.fmin(low, least - 2 * TAIL)), float(np.fmax(high, most - 2 * TAIL))
