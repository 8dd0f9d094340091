import numpy as np
import pytest
import trimesh
from matplotlib.path import Path
from trimesh.transformations import random_rotation_matrix

from egad.evalset.engraving import DEPTH, Patch, best_patch, cut_text, engrave, outlines
from egad.geometry.rays import RayCaster

WALL = 0.0012
NOWHERE = np.empty((0, 3))
TEXTS = ["A0", "F2", "G6", "J"]


def inside(text, points):
    within = [Path(glyph).contains_points(points) for glyph in outlines(text)]
    return np.logical_xor.reduce(within)


def seen(mesh, points, inwards):
    return RayCaster(mesh).first_hits(points, np.tile(inwards, (len(points), 1))).distances


def found_depths(before, after, patch, size=0.012):
    """How deep the surface was cut, at points in the frame of the text, seen from above it."""
    across = np.linspace(-size / 2, size / 2, 81)
    grid = np.stack(np.meshgrid(across, across), -1).reshape(-1, 2)
    points = patch.middle + grid @ patch.frame[:, :2].T + 0.2 * patch.frame[:, 2]
    inwards = -patch.frame[:, 2]
    return grid, seen(after, points, inwards) - seen(before, points, inwards)


def as_cut(depth, within):
    """Equally deep within the letters and untouched beside them, but for rays along outlines."""
    return np.isclose(depth, np.where(within, DEPTH, 0), rtol=0, atol=1e-6).mean() > 0.98


@pytest.mark.parametrize("text", TEXTS)
def test_the_text_stands_there_to_be_read_from_outside(text):
    turn = random_rotation_matrix(np.random.default_rng(1).random(3))
    mesh = trimesh.creation.box((0.04, 0.03, 0.02), transform=turn)
    patch = Patch(turn[:3, :3] @ [0.0, 0.0, 0.01], turn[:3, :3], 0.0, 0)
    cut = cut_text(mesh, text, patch)
    grid, depth = found_depths(mesh, cut, patch)
    assert as_cut(depth, inside(text, grid))
    assert cut.is_watertight
    missing = 0.0006 * inside(text, grid).mean() * 0.012**2
    assert mesh.volume - cut.volume == pytest.approx(missing, rel=0.05)


def test_on_a_curved_surface_it_is_as_deep_as_on_a_flat_one():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.03)
    patch = best_patch(ball, "B4", WALL, NOWHERE)
    cut = cut_text(ball, "B4", patch)
    grid, depth = found_depths(ball, cut, patch)
    assert as_cut(depth, inside("B4", grid))


def test_it_keeps_away_from_grasps():
    mesh = trimesh.creation.box((0.05, 0.05, 0.05))
    free, touched = [0.0, -0.025, 0.0], np.eye(3)
    sides = np.concatenate([touched, -touched]) * 0.025
    sides = sides[np.abs(sides - free).sum(axis=1) > 0.01]
    patch = best_patch(mesh, "C3", WALL, np.repeat(sides, 3, axis=0))
    assert patch.contacts == 0
    assert np.abs(sides - patch.middle).max(axis=1).min() > 0.005
    crowded = np.concatenate([sides, [free]])
    assert best_patch(mesh, "C3", WALL, np.tile(crowded, (2, 1))).contacts == 0


@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.icosphere(subdivisions=3, radius=0.006),  # too round
        trimesh.creation.box((0.01, 0.005, 0.005)),  # too small
        trimesh.creation.box((0.05, 0.05, 0.0015)),  # too thin below it
    ],
)
def test_without_an_even_place_on_thick_enough_ground_there_is_none(mesh):
    assert engrave(mesh, "D1", WALL, NOWHERE) is None


def test_a_hidden_place_is_none():
    low, high = -np.array([0.02, 0.02, 0.02]), np.array([0.02, 0.02, 0.02])
    outer = trimesh.creation.box(bounds=[low, high])
    hollow = trimesh.util.concatenate([outer, trimesh.creation.box((0.036,) * 3)])
    patch = best_patch(outer, "E5", WALL, NOWHERE)
    assert np.abs(patch.middle).max() == pytest.approx(0.02)
    hollow.faces[len(outer.faces) :] = hollow.faces[len(outer.faces) :, ::-1]
    assert best_patch(hollow, "E5", WALL, NOWHERE).middle == pytest.approx(patch.middle)
