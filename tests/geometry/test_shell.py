import igl
import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError, UserError
from egad.geometry.manifold import to_mesh
from egad.geometry.repair import repair
from egad.geometry.self_intersections import crossings
from egad.geometry.shell import MAX_SPREAD, shell

WALL, HALF = 0.004, 0.002
RADIUS, HEIGHT, SIDES = 0.04, 0.06, np.array([0.07, 0.05, 0.04])


def raw(vertices, faces):
    return trimesh.Trimesh(vertices, faces, process=False)


def open_where(mesh, keep):
    part = mesh.copy()
    part.update_faces(keep)
    part.remove_unreferenced_vertices()
    return part


def bowl():
    """Half a sphere, its rim up."""
    angle = np.linspace(0, np.pi / 2, 40)
    return trimesh.creation.revolve(
        RADIUS * np.column_stack([np.sin(angle), -np.cos(angle)]), sections=160
    )


def cup():
    """A cylinder without its top."""
    mesh = trimesh.creation.cylinder(RADIUS, HEIGHT, sections=256)
    return open_where(mesh, mesh.face_normals[:, 2] < 0.9)


def crate():
    """A box without its top."""
    mesh = trimesh.creation.box(SIDES)
    return open_where(mesh, mesh.face_normals[:, 2] < 0.9)


def pane():
    """A rectangle that is not aligned with the axes."""
    x, y, _ = SIDES
    mesh = raw([[0, 0, 0], [x, 0, 0], [x, y, 0], [0, y, 0]], [[0, 1, 2], [0, 2, 3]])
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1, 2, 3)))


def bowl_volume():
    ball = 4 / 3 * np.pi * ((RADIUS + HALF) ** 3 - (RADIUS - HALF) ** 3)
    return ball / 2 + np.pi**2 * HALF**2 * RADIUS


def cup_volume():
    wall = np.pi * ((RADIUS + HALF) ** 2 - (RADIUS - HALF) ** 2) * HEIGHT
    rim = np.pi**2 * HALF**2 * RADIUS
    below = np.pi * (RADIUS**2 * HALF + np.pi / 2 * RADIUS * HALF**2 + 2 / 3 * HALF**3)
    return wall + rim + below + np.pi * (RADIUS - HALF) ** 2 * HALF


def crate_volume():
    x, y, z = SIDES
    around, base = 2 * (x + y), x * y
    outside = (around * HALF + np.pi * HALF**2) * z
    inside = base * HALF + (around * HALF - 4 * HALF**2) * (z - HALF)
    below = base * HALF + np.pi / 4 * around * HALF**2 + 2 / 3 * np.pi * HALF**3
    rim = np.pi / 2 * around * HALF**2 + (np.pi - 4) * 2 / 3 * HALF**3
    return outside + inside + below + rim


def pane_volume():
    """Steiner's formula."""
    x, y, _ = SIDES
    return WALL * x * y + np.pi / 2 * HALF**2 * 2 * (x + y) + 4 / 3 * np.pi * HALF**3


SURFACES = {
    "bowl": (bowl, bowl_volume),
    "cup": (cup, cup_volume),
    "crate": (crate, crate_volume),
    "pane": (pane, pane_volume),
}


@pytest.fixture(scope="module")
def thickened():
    return {name: repair(make(), "thicken", WALL) for name, (make, _) in SURFACES.items()}


def assert_sound(mesh):
    assert mesh.is_volume
    assert mesh.body_count == 1
    assert len(crossings(mesh.vertices, mesh.faces, 1e-6 * mesh.extents.max())) == 0


@pytest.mark.parametrize("name", SURFACES)
def test_a_shell_is_one_closed_body_with_the_volume_of_all_points_near_the_surface(name, thickened):
    found, (_, volume) = thickened[name], SURFACES[name]
    assert_sound(found.mesh)
    assert found.changed
    assert found.shell_thickness == WALL
    assert found.mesh.volume == pytest.approx(volume(), rel=0.01)


def test_points_are_inside_if_they_are_within_half_the_thickness(thickened):
    surface, mesh = crate(), thickened["crate"].mesh
    low, high = mesh.bounds
    points = np.random.default_rng(0).uniform(low - WALL, high + WALL, (4000, 3))
    _, distances, _ = trimesh.proximity.closest_point_naive(surface, points)
    clear = np.abs(distances - HALF) > 0.04 * WALL
    within = igl.fast_winding_number(mesh.vertices, mesh.faces, points) > 0.5
    assert np.array_equal(within[clear], (distances < HALF)[clear])
    assert 100 < within[clear].sum() < 3900


@pytest.mark.parametrize("make", [bowl, crate])
def test_neither_the_order_nor_the_winding_of_the_triangles_matters(make, thickened):
    surface, rng = make(), np.random.default_rng(5)
    order = rng.permutation(len(surface.vertices))
    faces = np.argsort(order)[surface.faces[rng.permutation(len(surface.faces))]]
    mixed = raw(surface.vertices[order], np.roll(faces, 1, axis=1)[:, ::-1])
    found, expected = repair(mixed, "thicken", WALL).mesh, thickened[make.__name__].mesh
    assert found.vertices.tobytes() == expected.vertices.tobytes()
    assert found.faces.tobytes() == expected.faces.tobytes()


def test_a_shell_of_twice_the_size_is_the_same_one_scaled(thickened):
    found = repair(crate().apply_scale(2), "thicken", 2 * WALL).mesh
    assert np.array_equal(found.vertices, 2 * thickened["crate"].mesh.vertices)


def moebius():
    """A surface with one side."""
    angle, across = np.meshgrid(np.linspace(0, 2 * np.pi, 60, endpoint=False), [-0.01, 0.01])
    reach = 0.04 + across * np.cos(angle / 2)
    points = [reach * np.cos(angle), reach * np.sin(angle), across * np.sin(angle / 2)]
    i = np.arange(60)
    low, high = np.append(i, 60), np.append(60 + i, 0)  # the far end joins the two sides crosswise
    a, b, c, d = low[:-1], low[1:], high[1:], high[:-1]
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return raw(np.stack(points, axis=2).reshape(-1, 3), faces)


def fins():
    """Three rectangles that meet at an edge."""
    turn = trimesh.transformations.rotation_matrix
    flat = raw([[0, 0, 0], [0.03, 0, 0], [0.03, 0, 0.05], [0, 0, 0.05]], [[0, 1, 2], [0, 2, 3]])
    parts = [flat.copy().apply_transform(turn(angle, (0, 0, 1))) for angle in (0, 2, 4)]
    return trimesh.util.concatenate(parts)


def crossed():
    """Two rectangles that pass through each other, with no common edge."""
    turn = trimesh.transformations.rotation_matrix(1.3, (1, 0, 0), pane().centroid)
    return trimesh.util.concatenate([pane(), pane().apply_transform(turn)])


def two_sided():
    """A surface whose triangles are there twice, once from either side."""
    surface = cup()
    return raw(surface.vertices, np.vstack([surface.faces, surface.faces[:, ::-1]]))


@pytest.mark.parametrize("make", [moebius, fins, crossed])
def test_faces_may_meet_in_any_way(make):
    surface = make()
    found = repair(surface, "thicken", 0.002).mesh
    assert_sound(found)
    assert found.volume == pytest.approx(0.002 * surface.area, rel=0.12)


def test_a_surface_with_both_sides_is_that_with_one(thickened):
    with pytest.raises(RejectedError, match="no volume"):
        repair(two_sided())
    found = repair(two_sided(), "thicken", WALL)
    assert found.mesh.vertices.tobytes() == thickened["cup"].mesh.vertices.tobytes()


def test_a_closed_part_that_an_open_one_touches_becomes_one_body_with_it():
    foot = trimesh.creation.box((0.1, 0.1, 0.02)).apply_translation((0, 0, -HEIGHT / 2 - 0.01))
    found = repair(trimesh.util.concatenate([cup(), foot]), "thicken", WALL)
    assert_sound(found.mesh)
    below = np.pi * (RADIUS**2 * HALF + np.pi / 2 * RADIUS * HALF**2 + 2 / 3 * HALF**3)
    assert found.mesh.volume == pytest.approx(foot.volume + cup_volume() - below, rel=0.01)


def test_voids_that_the_wall_encloses_are_filled():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.02)
    filled = to_mesh(shell(ball, WALL))
    assert_sound(filled)
    assert filled.volume == pytest.approx(4 / 3 * np.pi * (0.02 + HALF) ** 3, rel=0.01)


def test_what_can_be_closed_is_not_thickened():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
    holed = raw(ball.vertices, ball.faces[5:])
    for given in (ball, holed):
        found, expected = repair(given, "thicken"), repair(given)
        assert found.shell_thickness == expected.shell_thickness == 0
        assert found.mesh.vertices.tobytes() == expected.mesh.vertices.tobytes()
        assert found.mesh.faces.tobytes() == expected.mesh.faces.tobytes()


def test_a_repaired_shell_is_left_alone(thickened):
    for shells in thickened.values():
        again = repair(shells.mesh, "thicken")
        assert not again.changed
        assert np.array_equal(again.mesh.faces, shells.mesh.faces)


def test_walls_that_cannot_be_made_say_what_can():
    with pytest.raises(RejectedError, match="smaller than the thickness of its shell"):
        repair(crate(), "thicken", 0.08)
    large = crate().apply_scale(1000)  # 70 m: millimetres taken for metres
    thinnest = np.sqrt(large.area / MAX_SPREAD)
    with pytest.raises(RejectedError, match=f"at least {thinnest:.3g} m, .* unit of the mesh"):
        repair(large, "thicken")


@pytest.mark.parametrize("thickness", [0, -0.001, np.nan, np.inf, "2mm", None])
def test_a_thickness_is_positive(thickness):
    with pytest.raises(
        UserError, match=f"thickness is {thickness!r}; allowed: a finite number, above 0"
    ):
        repair(crate(), "thicken", thickness)


def test_an_unknown_way_with_open_surfaces_is_told_with_those_allowed():
    with pytest.raises(UserError, match="'close' is not known; known: reject, thicken"):
        repair(crate(), "close")
