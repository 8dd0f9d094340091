import numpy as np
import pytest
import trimesh

from egad.exchange.distance_field import STEPS, distance_field, grid_nodes


def slow_distance(point, triangles):
    """The least distance to many triangles: to their corners, edges and inner points in turn."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.einsum("nk,nk->n", point - triangles[:, 0], normals)
    feet = point - heights[:, None] * normals
    best, over = np.inf, np.full(len(triangles), True)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        starts = triangles[:, start]
        along = triangles[:, end] - starts
        part = np.einsum("nk,nk->n", point - starts, along) / (along**2).sum(axis=1)
        nearest = starts + np.clip(part, 0, 1)[:, None] * along
        best = min(best, np.linalg.norm(point - nearest, axis=1).min())
        over &= np.einsum("nk,nk->n", np.cross(along, feet - starts), normals) >= 0
    return min(best, np.abs(heights[over]).min(initial=np.inf))


def slow_winding(point, triangles):
    """How often the surface goes around a point: the sum of the solid angles of its triangles."""
    a, b, c = (triangles[:, i] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    dots = [np.einsum("ij,ij->i", *pair) for pair in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    above = np.einsum("ij,ij->i", a, np.cross(b, c))
    return np.arctan2(above, below).sum() / (2 * np.pi)


def test_distances_are_those_of_a_slow_search(spiky_box):
    mesh = spiky_box(1)
    mesh.apply_scale(0.07)
    field = distance_field(mesh, 9, 1)
    nodes = grid_nodes(9, field.origin, field.resolution)
    triangles = np.asarray(mesh.triangles)
    truth = [
        slow_distance(node, triangles) * (-1 if slow_winding(node, triangles) > 0.5 else 1)
        for node in nodes
    ]
    assert min(truth) < 0
    error = np.abs(field.values.ravel() - truth)
    assert error.max() <= field.resolution / 2**STEPS


def test_the_field_of_a_ball_is_negative_within():
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.03)
    field = distance_field(ball, 32, 2)
    nodes = grid_nodes(32, field.origin, field.resolution)
    truth = np.linalg.norm(nodes, axis=1) - 0.03
    assert field.values.ravel() == pytest.approx(truth, abs=5e-5)


def test_the_grid_is_that_of_the_original():
    bar = trimesh.creation.box((0.03, 0.05, 0.09))
    bar.apply_translation((1.0, 2.0, 3.0))
    field = distance_field(bar, 100, 5)
    assert field.resolution == pytest.approx(0.09 / 90)
    assert field.origin == pytest.approx(np.array([1, 2, 3]) - 50 * field.resolution)
    assert field.values.shape == (100, 100, 100)
    assert field.values.dtype == np.float32
    # the first index is x: along it, the surface is 15 cells from the middle
    assert field.values[65, 50, 50] == pytest.approx(0, abs=1e-6)
    assert field.values[50, 75, 50] == pytest.approx(0, abs=1e-6)


def test_some_node_lies_on_every_surface(spiky_box):
    for number in range(3):
        field = distance_field(spiky_box(number), 32, 2)
        assert np.abs(field.values).min() < field.resolution * np.sqrt(2) / 2
