import numpy as np
import pytest
import trimesh

from egad.geometry.refinement import face_areas, lexicographic, refine, triangulation


def ends(faces):
    return np.sort(np.stack((faces, np.roll(faces, -1, axis=1)), axis=2), axis=2)


def test_edges_are_those_of_trimesh(lumpy, triangulate):
    mesh = triangulate(lumpy)
    assert np.array_equal(mesh.edges, np.unique(np.sort(lumpy.edges, axis=1), axis=0))
    assert np.array_equal(mesh.edges[mesh.face_edges], ends(lumpy.faces))


def test_lexicographic_order_is_that_of_numpy():
    low, high = np.random.default_rng(0).integers(0, 7, (2, 100)).astype(np.int32)
    assert np.array_equal(lexicographic(low, high, 7), np.lexsort((high, low)))


def test_face_areas(lumpy, triangulate):
    assert face_areas(triangulate(lumpy)) == pytest.approx(lumpy.area_faces)


def test_refinement_leaves_the_shape_as_it_is(lumpy, triangulate):
    fine = refine(triangulate(lumpy), 1000)
    mesh = trimesh.Trimesh(fine.vertices, fine.faces, process=False)
    assert len(mesh.vertices) == 1000
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(lumpy.volume)
    assert mesh.area == pytest.approx(lumpy.area)
    assert np.array_equal(mesh.vertices[:162], lumpy.vertices)
    assert np.array_equal(np.sort(fine.edges, axis=1)[fine.face_edges], ends(fine.faces))


def test_a_fine_mesh_stays_as_it_is(lumpy, triangulate):
    mesh = triangulate(lumpy)
    assert np.array_equal(refine(mesh, 100).vertices, mesh.vertices)
    assert np.array_equal(refine(mesh, 162).faces, mesh.faces)


def test_the_longest_edge_is_split_each_time(triangulate):
    box = trimesh.creation.box(extents=[1, 2.1, 3.3])
    box.vertices += np.random.default_rng(0).normal(size=(8, 3)) * 0.1
    for count in range(8, 60):
        mesh = refine(triangulate(box), count)
        corners = mesh.vertices[mesh.edges]
        lengths = np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)
        longest = corners[lengths > lengths.max() - 1e-12]
        added = refine(triangulate(box), count + 1).vertices[-1]
        assert np.abs(longest.mean(axis=1) - added).max(axis=1).min() < 1e-12


def test_edges_with_one_and_with_three_faces():
    vertices = np.array([[0, 0, 0], [0, 0, 5], [1, 0, 2], [-1, 0.5, 2], [-1, -0.5, 2]], float)
    mesh = triangulation(vertices, np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]], np.int32))
    fine = refine(mesh, 60)
    assert face_areas(fine).sum() == pytest.approx(face_areas(mesh).sum())
    assert np.array_equal(np.sort(fine.edges, axis=1)[fine.face_edges], ends(fine.faces))
    meeting = np.bincount(fine.face_edges.ravel())
    on_the_fold = (fine.vertices[fine.edges][:, :, :2] == 0).all(axis=(1, 2))
    assert on_the_fold.sum() > 3
    assert set(meeting[on_the_fold]) == {3}
    assert set(meeting[~on_the_fold]) == {1, 2}
