import manifold3d
import numpy as np
import pytest
import trimesh

import egad
from egad.errors import RejectedError
from egad.geometry import to_mesh
from egad.measures.complexity import angular_deficits, complexity, corner_angles


def bumpy(subdivisions=3):
    mesh = trimesh.creation.icosphere(subdivisions)
    radius = np.random.default_rng(0).uniform(0.8, 1.2, len(mesh.vertices))
    return trimesh.Trimesh(mesh.vertices * radius[:, None], mesh.faces, process=False)


def slow_complexity(mesh, bins):
    """Vertex by vertex, with a histogram in a dictionary."""
    counts, vertices, faces = {}, np.array(mesh.vertices), np.array(mesh.faces)
    for v in range(len(vertices)):
        angles = 0.0
        for face in faces[(faces == v).any(axis=1)]:
            a, b = (vertices[w] - vertices[v] for w in face if w != v)
            angles += np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))
        key = int((2 * np.pi - angles + 2 * np.pi) / (4 * np.pi) * bins)
        counts[key] = counts.get(key, 0) + 1
    shares = [count / len(mesh.vertices) for count in counts.values()]
    return sum(share * np.log2(1 / share) for share in shares)


def test_equals_a_slow_twin():
    mesh = bumpy(subdivisions=2)
    assert complexity(mesh) == pytest.approx(slow_complexity(mesh, 512), abs=1e-12)
    assert complexity(mesh, 64) == pytest.approx(slow_complexity(mesh, 64), abs=1e-12)


def bracket():
    angle = manifold3d.Manifold.cube((60, 40, 5)) + manifold3d.Manifold.cube((60, 5, 40))
    hole = manifold3d.Manifold.cylinder(20, 4, 4, 24).translate((15, 20, -5))
    return to_mesh(angle - hole - hole.translate((30, 0, 0)))


def fine_box():
    return trimesh.creation.box([60, 40, 30]).subdivide().subdivide().subdivide()


SOLIDS = {
    "fine box": fine_box,
    "bracket": bracket,
    "cylinder": lambda: trimesh.creation.cylinder(20, 50, sections=32),
    "ring": lambda: trimesh.creation.annulus(20, 30, 15, sections=48),
    "evolved": lambda: egad.load("released")["M14_3"].mesh.copy().apply_scale(1000),
}
DIGITS = {
    "all": lambda points: points,
    "single precision": lambda points: points.astype(np.float32).astype(float),
    "single precision, metres": lambda points: 1000 * (points / 1000).astype(np.float32),
    "six decimals": lambda points: points.round(6),
    "four decimals": lambda points: points.round(4),
    "six digits": np.vectorize(lambda number: float(f"{number:.6g}")),
    "six decimals of metres": lambda points: 1000 * (points / 1000).round(6),
}


TURN = trimesh.transformations.euler_matrix(0.3, 0.5, 0.7)


@pytest.mark.parametrize("pose", [np.eye(4), TURN], ids=["upright", "turned"])
@pytest.mark.parametrize("solid", SOLIDS)
def test_the_digits_of_a_file_do_not_matter(solid, pose):
    mesh = SOLIDS[solid]().apply_transform(pose).apply_translation([3.1, 1.7, -5.3])
    exact = complexity(mesh)
    for digits, rounded in DIGITS.items():
        points = rounded(np.asarray(mesh.vertices))
        again = trimesh.Trimesh(points, mesh.faces, process=False)
        assert complexity(again) == pytest.approx(exact, abs=0.01), digits


@pytest.mark.parametrize("digits", DIGITS)
def test_vertices_in_a_plane_or_on_a_straight_edge_count_as_flat(digits):
    # 8 corners, all other vertices flat: known whatever the digits
    mesh = fine_box().apply_transform(TURN)
    rounded = DIGITS[digits](np.asarray(mesh.vertices))
    corners = 8 / len(mesh.vertices)
    expected = -corners * np.log2(corners) - (1 - corners) * np.log2(1 - corners)
    assert complexity(trimesh.Trimesh(rounded, mesh.faces)) == pytest.approx(expected)


def test_shallow_curvature_is_not_taken_for_rounding():
    # a ball that is dented everywhere by less than a bin; dents of both signs
    mesh = trimesh.creation.icosphere(4)
    waves = 1e-4 * np.sin(30 * mesh.vertices).sum(axis=1)
    mesh.vertices *= (1 + waves)[:, None]
    assert complexity(mesh) == pytest.approx(slow_complexity(mesh, 512), abs=1e-3)


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
