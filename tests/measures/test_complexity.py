import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.measures.complexity import angular_deficits, complexity, corner_angles


def bumpy(subdivisions=3):
    mesh = trimesh.creation.icosphere(subdivisions)
    radius = np.random.default_rng(0).uniform(0.8, 1.2, len(mesh.vertices))
    return trimesh.Trimesh(mesh.vertices * radius[:, None], mesh.faces, process=False)


def slow_complexity(mesh, bins):
    """Vertex by vertex, with a histogram in a dictionary."""
    counts = {}
    for v in range(len(mesh.vertices)):
        angles = 0.0
        for face in mesh.faces:
            if v in face:
                a, b = (mesh.vertices[w] - mesh.vertices[v] for w in face if w != v)
                angles += np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))
        key = int((2 * np.pi - angles + 2 * np.pi) / (4 * np.pi) * bins)
        counts[key] = counts.get(key, 0) + 1
    shares = [count / len(mesh.vertices) for count in counts.values()]
    return sum(share * np.log2(1 / share) for share in shares)


def test_equals_a_slow_twin():
    mesh = bumpy(subdivisions=2)
    assert complexity(mesh) == pytest.approx(slow_complexity(mesh, 512), abs=1e-12)
    assert complexity(mesh, 64) == pytest.approx(slow_complexity(mesh, 64), abs=1e-12)


def test_a_box_has_no_complexity():
    assert complexity(trimesh.creation.box([1, 2, 3])) == 0


def test_flat_vertices_share_a_bin():
    # 8 corners of deficit pi / 2, all others flat up to rounding
    box = trimesh.creation.box([1, 0.7, 0.3])
    box.apply_transform(trimesh.transformations.rotation_matrix(1.0, [0.1, 0.5, 0.8]))
    fine = box.subdivide().subdivide().subdivide()
    corners = 8 / len(fine.vertices)
    expected = -corners * np.log2(corners) - (1 - corners) * np.log2(1 - corners)
    assert complexity(fine) == pytest.approx(expected)


def test_deficits_of_a_closed_surface_add_up_to_its_euler_number():
    assert angular_deficits(bumpy()).sum() == pytest.approx(4 * np.pi)
    assert angular_deficits(trimesh.creation.torus(3, 1)).sum() == pytest.approx(0, abs=1e-9)


def test_size_and_place_do_not_matter():
    mesh = bumpy()
    moved = trimesh.Trimesh(mesh.vertices * 1e-3 + 0.25, mesh.faces, process=False)
    assert complexity(moved) == pytest.approx(complexity(mesh), abs=0.01)


def test_vertices_without_faces_do_not_count():
    mesh = bumpy()
    vertices = np.concatenate([mesh.vertices, np.ones((500, 3))])
    more = trimesh.Trimesh(vertices, mesh.faces, process=False)
    assert complexity(more) == complexity(mesh)


def test_degenerate_triangles_do_no_harm():
    mesh = bumpy()
    faces = np.concatenate([mesh.faces, [[0, 0, 1], [2, 2, 2]]])
    spoiled = trimesh.Trimesh(mesh.vertices, faces, process=False)
    assert complexity(spoiled) == pytest.approx(complexity(mesh), abs=0.05)
    assert (corner_angles(np.zeros((1, 3, 3))) == 0).all()
    needle = corner_angles(np.array([[[0, 0, 0], [1, 0, 0], [1, 1e-100, 0]]]))
    assert needle.sum() == pytest.approx(np.pi)


def test_extreme_deficits_stay_within_the_histogram():
    # a fan of 40 right angles around one vertex: a deficit far below -2 pi
    turn = np.arange(41) * np.pi / 2
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(41)], axis=1)
    faces = [[0, i + 1, i + 2] for i in range(40)]
    fan = trimesh.Trimesh(np.concatenate([[[0, 0, 0]], ring]), faces, process=False)
    assert 0 < complexity(fan) < 9


def test_a_mesh_without_faces_is_rejected():
    with pytest.raises(RejectedError, match="no faces"):
        complexity(trimesh.Trimesh(np.zeros((3, 3)), np.empty((0, 3), dtype=int), process=False))
