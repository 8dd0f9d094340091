"""The label of an object, cut into its surface so that prints can be told apart (ours)."""

from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from scipy.spatial import cKDTree

from egad._util.arrays import Floats
from egad.geometry import RayCaster, is_solid, spread, to_mesh, to_solid

FONT = FontProperties(family="DejaVu Sans", weight="bold")  # comes with matplotlib
DEPTH = 0.0006  # metres below the surface
LETTERS = 0.006  # metres: height of the letters
# metres: largest height difference of the surface below a label; a less even object gets none
RELIEF = 0.001
STEP = 0.5  # of the height of the letters: between the positions tried
TURNS = 6  # of the text at each position, over half a turn
RIM = 0.15  # of the height of the letters: clearance around the text
RAYS = 8  # along each side of the text
ALIKE = 0.9  # length of the mean of the unit normals of a position that is flat enough to try
FINGER = 0.005  # metres: contacts closer to the text than this count as on it
SKIN = 1e-6  # metres below the surface, where rays start inwards


class Patch(NamedTuple):
    """A place for a text, on the surface; the columns of the frame are right, up and outwards.

    `relief` is the height of the highest point below the text over the lowest, metres; `contacts`
    is the number of grasp contacts on it.
    """

    middle: Floats
    frame: Floats
    relief: float
    contacts: int


def engrave(
    mesh: trimesh.Trimesh, text: str, wall: float, contacts: Floats
) -> trimesh.Trimesh | None:
    """A copy with a text cut into it at uniform depth, where it disturbs grasps least.

    The mesh is closed, wound outwards, metres, at the size that it is printed in. At least `wall`
    metres are left below the text. Of the places with the fewest of the contacts, (n, 3), the most
    even one is taken. None if there is no place, or the text would cut the object into pieces.
    """
    patch = best_patch(mesh, text, wall, contacts)
    return None if patch is None else cut_text(mesh, text, patch)


def cut_text(mesh: trimesh.Trimesh, text: str, patch: Patch) -> trimesh.Trimesh | None:
    """A copy with a text cut into it at a given place; None if the object falls apart.

    The floor of the letters is the surface itself, moved inwards by the depth.
    """
    solid = to_solid(mesh.vertices, mesh.faces)
    reach = RELIEF + DEPTH
    flat = manifold3d.CrossSection(outlines(text), manifold3d.FillRule.EvenOdd)
    place = np.column_stack([patch.frame, patch.middle - reach * patch.frame[:, 2]])
    prism = flat.extrude(2 * reach).transform(place)
    lowered = solid.translate(tuple(-DEPTH * patch.frame[:, 2]))
    cut = solid - (prism - lowered)
    return to_mesh(cut) if is_solid(cut) and len(cut.decompose()) == 1 else None


def outlines(text: str) -> list[Floats]:
    """Closed outlines (n, 2) of a text, its middle at the origin; holes wind the other way."""
    glyphs = TextPath((0, 0), text, size=1, prop=FONT).to_polygons()
    points = np.concatenate(glyphs)
    low, high = points.min(axis=0), points.max(axis=0)
    return [(glyph - (low + high) / 2) * LETTERS / (high[1] - low[1]) for glyph in glyphs]


def best_patch(mesh: trimesh.Trimesh, text: str, wall: float, contacts: Floats) -> Patch | None:
    """The most even place with the fewest contacts, open from above, over a solid thick enough."""
    glyphs = np.concatenate(outlines(text))
    size = np.ptp(glyphs, axis=0) + 2 * RIM * LETTERS
    middles, normals = _places(mesh, float(np.linalg.norm(size)) / 2)
    middles, frames = np.repeat(middles, TURNS, axis=0), _frames(normals)
    reliefs = _reliefs(RayCaster(mesh), middles, frames, size, DEPTH + wall)
    patches = [
        Patch(middle, frame, float(relief), _on_it(contacts, middle, frame, size))
        for middle, frame, relief in zip(middles, frames, reliefs, strict=True)
        if relief <= RELIEF
    ]
    return min(patches, key=lambda patch: (patch.contacts, patch.relief), default=None)


def _places(mesh: trimesh.Trimesh, radius: float) -> tuple[Floats, Floats]:
    """Points about `STEP` letters apart where the surface is about even, and normals, (n, 3)."""
    samples = spread(mesh, STEP * LETTERS)
    cells = np.floor(samples.points / (STEP * LETTERS))
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])
    normals = samples.normals
    around = cKDTree(samples.points).query_ball_point(samples.points[first], radius)
    # only points that face the same way: not the other side of a thin wall
    means = np.array(
        [
            normals[near][normals[near] @ normals[one] > 0].mean(axis=0)
            for one, near in zip(first, around, strict=True)
        ]
    )
    length = np.linalg.norm(means, axis=1)
    even = length >= ALIKE
    return samples.points[first][even], means[even] / length[even, None]


def _frames(normals: Floats) -> Floats:
    """Frames (n * TURNS, 3, 3) that have the normals (n, 3) as third columns, turned about them."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    right = np.cross(least, normals)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(normals, right)
    turns = np.arange(TURNS) * np.pi / TURNS
    across = np.cos(turns)[:, None] * right[:, None] + np.sin(turns)[:, None] * up[:, None]
    out = np.broadcast_to(normals[:, None], across.shape)
    frames: Floats = np.stack([across, np.cross(out, across), out], axis=3).reshape(-1, 3, 3)
    return frames


def _reliefs(
    caster: RayCaster, middles: Floats, frames: Floats, size: Floats, thickness: float
) -> Floats:
    """How uneven each place is, metres, (n,); infinite if it is hidden or the solid too thin."""
    across, along = (np.linspace(-0.5, 0.5, RAYS) * side for side in size)
    grid = np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)
    inwards = np.repeat(-frames[:, :, 2], len(grid), axis=0)
    points = (middles[:, None] + grid @ np.swapaxes(frames[:, :, :2], 1, 2)).reshape(-1, 3)
    away = float(np.linalg.norm(caster.mesh.extents))
    heights = away - caster.first_hits(points - away * inwards, inwards).distances
    met = np.isfinite(heights)
    starts = points + (SKIN - np.where(met, heights, 0)[:, None]) * inwards
    solid = caster.first_hits(starts, inwards).distances >= thickness
    heights = np.where(met & solid, heights, np.inf).reshape(-1, len(grid))
    return np.asarray(np.maximum(heights.max(axis=1), 0) - np.minimum(heights.min(axis=1), 0))


def _on_it(contacts: Floats, middle: Floats, frame: Floats, size: Floats) -> int:
    """How many contacts lie on a place or less than a finger away from it."""
    local = np.abs((contacts - middle) @ frame)
    return int((local <= [*(size / 2 + FINGER), RELIEF + FINGER]).all(axis=1).sum())
