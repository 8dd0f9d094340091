"""Solids that touch themselves: boxes and random voxels, whose volumes and bodies are known."""

import time

import numpy as np
import pytest
import trimesh
from scipy import ndimage

import egad
from egad.evalset import PrintCheck, print_problems
from egad.geometry import is_solid, to_solid
from egad.geometry.checks import is_closed
from egad.geometry.repair import repair
from egad.geometry.touching import separated
from egad.io import read_mesh, write_mesh

SIDE = 0.02
RING = [(0, 0, 0), (1, 1, 0), (2, 0, 0), (1, -1, 0)]
CORNERS = [(0, 0, 0), (1, 1, 1)]


def cubes(places, side=SIDE):
    boxes = [
        trimesh.creation.box((side,) * 3).apply_translation(side * np.array(p)) for p in places
    ]
    return trimesh.util.concatenate(boxes)


def merged(mesh):
    mesh = mesh.copy()
    mesh.merge_vertices()
    return mesh


def surface(filled, rng):
    """The faces of voxels of unit size that have no neighbour, each divided along some diagonal."""
    padded, triangles = np.pad(filled, 1), []
    for axis in range(3):
        for sign in (1, -1):
            u, v = np.roll(np.eye(3), -axis, axis=0)[[1, 2] if sign > 0 else [2, 1]]
            for cell in np.argwhere(padded & ~np.roll(padded, -sign, axis)):
                middle = cell + np.eye(3)[axis] * sign / 2
                signs = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
                quad = [middle + (a * u + b * v) / 2 for a, b in signs]
                quad = np.roll(quad, rng.integers(2), axis=0)
                triangles += [quad[[0, 1, 2]], quad[[0, 2, 3]]]
    corners = np.reshape(triangles, (-1, 3))
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def voxels(count):
    """Random ones without trapped voids."""
    rng = np.random.default_rng(0)
    while count:
        filled = rng.random((4, 4, 4)) < rng.uniform(0.2, 0.8)
        if filled.any() and ndimage.label(~np.pad(filled, 1))[1] == 1:
            count -= 1
            yield filled, merged(surface(filled, rng))


def test_solids_keep_their_volume():
    """Alone, manifold3d pairs faces at edges with four of them in any way, and loses some."""
    for filled, mesh in voxels(30):
        assert is_closed(mesh)
        vertices, faces = separated(mesh.vertices, mesh.faces)
        assert trimesh.Trimesh(vertices, faces, process=False).is_watertight
        solid = to_solid(mesh.vertices, mesh.faces)
        assert solid.num_tri() == len(faces)
        assert solid.volume() == pytest.approx(filled.sum())


def test_what_is_wound_inconsistently_is_no_solid():
    for _, mesh in voxels(5):
        torn = mesh.faces.copy()
        torn[0] = torn[0, ::-1]
        assert not is_solid(to_solid(mesh.vertices, torn))
        assert separated(mesh.vertices, torn)[1] is torn


def test_voxels_that_touch_are_one_body():
    for filled, mesh in voxels(20):
        labels = ndimage.label(filled, np.ones((3, 3, 3)))[0]
        repaired = repair(mesh)
        assert repaired.mesh.volume == pytest.approx(np.bincount(labels[filled]).max())
        assert repaired.dropped_bodies == labels.max() - 1


@pytest.mark.parametrize("ending", ["stl", "obj"])
@pytest.mark.parametrize(
    ("places", "where"),
    [(RING, "along an edge near (10.00, -10.00, 0.00) mm"), (CORNERS, "in a point near (10.00, ")],
)
def test_all_cubes_are_kept_and_the_print_check_says_where_they_touch(
    tmp_path, places, where, ending
):
    cubes(places).export(tmp_path / f"a.{ending}")
    repaired = repair(egad.read_mesh(tmp_path / f"a.{ending}", units="m"))
    assert repaired.dropped_bodies == 0
    scaled, factor = egad.rescale(repaired.mesh, egad.Gripper(opening=0.25))
    write_mesh(scaled, tmp_path / "b.obj")
    again = repair(read_mesh(tmp_path / "b.obj", "m")).mesh
    for mesh, scale in ((repaired.mesh, 1), (scaled, factor), (again, factor)):
        assert mesh.volume == pytest.approx(len(places) * (scale * SIDE) ** 3)
        (problem,) = print_problems(mesh, PrintCheck())
        assert problem.startswith(f"touches itself {where}" if scale == 1 else "touches itself ")


def test_boxes_that_share_a_face_become_one():
    """Whichever way the face is divided in each of them."""
    pair = [(0, 0, 0), (1, 0, 0)]
    turned = cubes(pair)
    turned.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    for mesh in (cubes(pair), turned):
        repaired = repair(mesh)
        assert 1e9 * repaired.mesh.volume == pytest.approx(16_000)
        assert repaired.dropped_bodies == 0
        assert print_problems(repaired.mesh, PrintCheck()) == []


def test_the_time_grows_with_the_number_of_bodies():
    ball, places = (
        trimesh.creation.icosphere(subdivisions=0),
        np.indices((22, 22, 22)).reshape(3, -1),
    )
    count = 3000  # in time that grows with its square: 41 s
    shifts = 3.0 * places.T[:count]
    vertices = (ball.vertices + shifts[:, None]).reshape(-1, 3)
    faces = (ball.faces + 12 * np.arange(count)[:, None, None]).reshape(-1, 3)
    before = time.process_time()
    repaired = repair(trimesh.Trimesh(vertices, faces, process=False))
    assert time.process_time() - before < 15
    assert repaired.dropped_bodies == count - 1
    assert repaired.mesh.volume == pytest.approx(ball.volume)
