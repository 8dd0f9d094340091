import numpy as np
import pytest
import trimesh

from egad.geometry.rays import LibiglScene, RayCaster, TriangleScene


def blob(seed=0):
    """A bumpy closed surface of 1280 faces, not convex."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    bumps = np.random.default_rng(seed).normal(size=(3, 3)) * 3
    radius = 0.04 * (1 + 0.3 * np.sin(mesh.vertices @ bumps).prod(axis=1))
    return trimesh.Trimesh(mesh.vertices * radius[:, None], mesh.faces, process=False)


def random_rays(count, seed=0):
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return rng.normal(0, 0.03, (count, 3)), directions


def slow_first_hit(mesh, origin, direction):
    """Solve for every triangle."""
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    matrix = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=2)
    u, v, t = np.linalg.solve(matrix, (origin - a)[..., None])[..., 0].T
    distances = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf)
    nearest = distances.argmin()
    return distances[nearest], mesh.face_normals[nearest]


def test_equals_a_search_through_all_triangles():
    mesh = blob()
    origins, directions = random_rays(500)
    hits = RayCaster(mesh).first_hits(origins, directions)
    for i in range(500):
        distance, normal = slow_first_hit(mesh, origins[i], directions[i])
        assert hits.distances[i] == pytest.approx(distance, abs=1e-9)
        if np.isfinite(distance):
            assert hits.entering[i] == (normal @ directions[i] < 0)
            np.testing.assert_allclose(hits.normals[i], normal, atol=1e-12)
    assert 0.2 < np.isfinite(hits.distances).mean() < 0.9


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_size_and_place_do_not_matter(factor):
    mesh = blob()
    origins, directions = random_rays(300)
    expected = RayCaster(mesh).first_hits(origins, directions)
    place = np.array([0.3, -0.2, 0.1])
    moved = trimesh.Trimesh((mesh.vertices + place) * factor, mesh.faces, process=False)
    hits = RayCaster(moved).first_hits((origins + place) * factor, directions)
    np.testing.assert_allclose(hits.distances, expected.distances * factor, rtol=1e-9)


def test_no_ray_leaks_through_edges_and_vertices():
    mesh = trimesh.creation.box([0.1, 0.1, 0.1])
    grid = np.linspace(-0.05, 0.05, 21)
    y, z = (each.ravel() for each in np.meshgrid(grid, grid))
    origins = np.stack([np.zeros(len(y)), 0.999 * y, 0.999 * z], axis=1)
    hits = RayCaster(mesh).first_hits(origins, np.tile([1.0, 0, 0], (len(y), 1)))
    np.testing.assert_allclose(hits.distances, 0.05, atol=1e-12)
    assert not hits.entering.any()


def test_misses():
    caster = RayCaster(trimesh.creation.box([0.1, 0.1, 0.1]))
    origins, away = np.array([[1.0, 0, 0]]), np.array([[1.0, 0, 0]])
    hits = caster.first_hits(origins, away)
    assert np.isinf(hits.distances[0])
    assert not hits.entering[0]
    assert not caster.obstructed(origins, -away, 0.9)[0]
    assert caster.obstructed(origins, -away, 0.96)[0]


def test_degenerate_triangles_do_no_harm():
    mesh = blob()
    faces = np.concatenate([mesh.faces, [[0, 0, 1], [2, 2, 2]]])
    origins, directions = random_rays(200)
    spoiled = RayCaster(trimesh.Trimesh(mesh.vertices, faces, process=False))
    expected = RayCaster(mesh).first_hits(origins, directions)
    hits = spoiled.first_hits(origins, directions)
    np.testing.assert_array_equal(hits.distances, expected.distances)
    np.testing.assert_array_equal(hits.entering, expected.entering)


def test_inside_is_that_of_a_ball():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=1)
    points = np.random.default_rng(3).uniform(-1, 1, (500, 3))
    distances = np.linalg.norm(points, axis=1)
    clear = np.abs(distances - 1) > 0.01
    found = RayCaster(ball).contains(points)
    np.testing.assert_array_equal(found[clear], distances[clear] < 1)


def test_a_scene_meets_the_same_triangles_in_single_precision():
    mesh = blob()
    origins, directions = random_rays(500)
    exact = RayCaster(mesh).first_hits(origins, directions)
    scene = TriangleScene(mesh.vertices, mesh.faces)
    found, hit = scene.intersections(origins, 2 * directions), np.isfinite(exact.distances)
    np.testing.assert_allclose(2 * found.distances, exact.distances, rtol=1e-3, atol=1e-6)
    np.testing.assert_array_equal(scene.distances(origins, 2 * directions), found.distances)
    np.testing.assert_array_equal(scene.occluded(origins, directions), hit)
    np.testing.assert_array_equal(found.faces >= 0, hit)
    u, v = found.coordinates[hit].T
    corners = mesh.triangles[found.faces[hit]]
    weights = np.stack([1 - u - v, u, v], axis=1)
    met = origins[hit] + exact.distances[hit, None] * directions[hit]
    np.testing.assert_allclose(np.einsum("ij,ijk->ik", weights, corners), met, atol=1e-6)
    across = np.cross(found.normals[hit], exact.normals[hit])
    assert np.linalg.norm(across, axis=1).max() < 1e-4 * np.abs(found.normals).max()


@pytest.mark.parametrize(
    "check",
    [
        test_equals_a_search_through_all_triangles,
        test_no_ray_leaks_through_edges_and_vertices,
        test_misses,
        test_degenerate_triangles_do_no_harm,
        test_inside_is_that_of_a_ball,
        test_a_scene_meets_the_same_triangles_in_single_precision,
    ],
)
def test_rays_are_right_without_embreex(check, monkeypatch):
    pytest.importorskip("igl")
    monkeypatch.setattr("egad.geometry.rays.embree_scene", LibiglScene)
    check()
