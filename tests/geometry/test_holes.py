import numpy as np
import pytest
import trimesh

from egad.geometry.repair import close_holes, open_edges, simple_loops


def without(mesh, faces):
    kept = np.setdiff1d(np.arange(len(mesh.faces)), faces)
    return trimesh.Trimesh(mesh.vertices, mesh.faces[kept], process=False)


def test_a_missing_patch_is_filled_as_it_was():
    block = trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    flat = np.flatnonzero(block.face_normals[:, 0] > 0.9)
    inner = flat[np.linalg.norm(block.triangles_center[flat, 1:], axis=1) < 0.7]
    assert len(inner) > 4
    closed = close_holes(without(block, inner), 0.5)
    assert closed.is_volume
    assert closed.volume == pytest.approx(6)
    assert closed.area == pytest.approx(22)


def test_a_bent_rim_is_closed():
    ball = trimesh.creation.icosphere(subdivisions=3)
    bent = (ball.triangles_center[:, 2] > 0.8) | (ball.triangles_center[:, 0] > 0.9)
    closed = close_holes(without(ball, np.flatnonzero(bent)), 0.5)
    assert closed.is_volume


def test_holes_that_are_too_large_stay_open():
    block = trimesh.creation.box()
    open_block = without(block, np.flatnonzero(block.face_normals[:, 2] > 0.9))
    assert close_holes(open_block, 0.19) is None
    assert close_holes(open_block, 0.21).volume == pytest.approx(1)


def test_a_closed_surface_has_no_open_edges_and_comes_back():
    ball = trimesh.creation.icosphere(subdivisions=1)
    assert len(open_edges(ball.faces)) == 0
    assert np.array_equal(close_holes(ball, 0.1).faces, ball.faces)


def test_open_edges_run_as_the_missing_triangle():
    block = trimesh.creation.box()
    missing = block.faces[3]
    edges = {tuple(edge) for edge in open_edges(without(block, [3]).faces).tolist()}
    assert edges == set(zip(missing.tolist(), np.roll(missing, -1).tolist(), strict=True))


def test_loops_that_share_a_vertex_are_told_apart():
    eight = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]])
    loops = simple_loops(eight)
    assert sorted(map(sorted, loops)) == [[0, 1, 2], [0, 3, 4]]


def test_edges_that_lead_nowhere_form_no_loops():
    assert simple_loops(np.array([[0, 1], [1, 2]])) is None
    assert simple_loops(np.empty((0, 2), dtype=int)) == []
