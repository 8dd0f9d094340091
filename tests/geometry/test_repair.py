import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.geometry.manifold import to_mesh, to_solid
from egad.geometry.repair import dropped_text, repair
from egad.geometry.self_intersections import crossings, untangle

box, icosphere = trimesh.creation.box, trimesh.creation.icosphere


def raw(vertices, faces):
    return trimesh.Trimesh(vertices, faces, process=False)


def soup(mesh):
    """Every triangle with corners of its own, as in an STL file."""
    return raw(mesh.triangles.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def together(*meshes):
    return trimesh.util.concatenate(list(meshes))


def shifted(mesh, *offset):
    return mesh.copy().apply_translation(offset)


def crossing_tube(turns=1):
    """A tube along a figure of eight: one surface, which runs through itself at the middle."""
    t = np.linspace(0, 2 * np.pi * turns, 120, endpoint=False)
    path = np.column_stack([np.sin(t), np.sin(2 * t) / 2, np.zeros_like(t)])
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    side = np.cross([0, 0, 1], along / np.linalg.norm(along, axis=1, keepdims=True))
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * [0, 0, 1]
    i, j = np.meshgrid(np.arange(120), np.arange(16), indexing="ij")
    corner = [(a % 120) * 16 + b % 16 for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
    a, b, c, d = (index.ravel() for index in corner)
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    mesh = raw((path[:, None] + 0.12 * ring).reshape(-1, 3), faces)
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def assert_sound(mesh):
    assert mesh.is_volume
    assert mesh.body_count == 1
    assert len(crossings(mesh.vertices, mesh.faces, 1e-6 * mesh.extents.max())) == 0


def test_a_sound_mesh_comes_back_as_it_is():
    ball = icosphere(subdivisions=3)
    mesh, changed, *_ = repair(ball)
    assert not changed
    assert np.array_equal(mesh.vertices, ball.vertices)
    assert np.array_equal(mesh.faces, ball.faces)


@pytest.mark.parametrize("step", [1, 3])
def test_faces_that_are_inside_out_all_or_some_are_turned_round(step):
    ball = icosphere(subdivisions=2)
    faces = ball.faces.copy()
    faces[::step] = faces[::step, ::-1]
    mesh, changed, *_ = repair(raw(ball.vertices, faces))
    assert changed
    assert_sound(mesh)
    assert mesh.volume == pytest.approx(ball.volume)


def test_cracks_are_welded():
    given = soup(box((1, 1, 1)).subdivide())
    noise = np.random.default_rng(0).uniform(-2e-5, 2e-5, given.vertices.shape)
    mesh, changed, *_ = repair(raw(given.vertices + noise, given.faces))
    assert changed
    assert_sound(mesh)
    assert mesh.volume == pytest.approx(1, rel=1e-3)


def test_a_small_hole_is_closed_and_a_large_one_is_named():
    block = box()
    assert_sound(repair(raw(block.vertices, block.faces[1:])).mesh)
    with pytest.raises(RejectedError, match="open surface: 4 open edges"):
        repair(CUP)


def test_degenerate_and_doubled_faces_go():
    block = box()
    extra = [block.faces[0], [0, 0, 1], [0, 1, 2], [2, 1, 0]]
    mesh, changed, *_ = repair(raw(block.vertices, np.vstack([block.faces, extra])))
    assert changed
    assert_sound(mesh)
    assert mesh.volume == pytest.approx(1)


def test_a_fin_on_a_closed_body_is_dropped():
    block = box().subdivide()
    edge = block.faces[0, :2]
    vertices = np.vstack([block.vertices, block.vertices[edge].mean(axis=0) * 1.2])
    fin = [*edge, len(block.vertices)]
    mesh, *_ = repair(raw(vertices, np.vstack([block.faces, [fin]])))
    assert_sound(mesh)
    assert mesh.volume == pytest.approx(1)


@pytest.mark.parametrize(
    ("mesh", "bodies", "volume"),
    [
        (box(), 0, 0),
        (together(box(), shifted(box((0.5, 0.5, 0.5)), 3, 0, 0)), 1, 0.125 / 1.125),
        (together(*(shifted(box(), 2 * n, 0, 0) for n in range(4))), 3, 0.75),
        (together(box(), shifted(box(), 0.5, 0, 0)), 0, 0),  # they overlap
        (together(box(), box((0.5, 0.5, 0.5))), 0, 0),  # a void is no body
        (together(box(), shifted(box((0.01, 0.01, 0.01)), 3, 0, 0)), 0, 0),  # a crumb
        (crossing_tube(), 0, 0),
    ],
)
def test_bodies_that_are_dropped_are_counted_with_their_part_of_the_volume(mesh, bodies, volume):
    found = repair(mesh)
    assert found.dropped_bodies == bodies
    assert found.dropped_volume == pytest.approx(volume, abs=1e-9)
    assert bool(found.dropped) == (bodies > 0)


SHEET = raw([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]], [[0, 1, 2], [0, 2, 3]])
CUP = raw(box().vertices, box().faces[box().face_normals[:, 2] < 0.9])  # one side of a cube lacks


@pytest.mark.parametrize(
    ("shape", "side", "offset", "volume"),
    [
        ("cup", 0.32, 2, 0.32**3),  # 16 mm beside 50 mm
        ("cup", 0.32, 0, None),  # inside, where nothing is lost
        ("cup", 0.32, 0.5, 0.32**3 / 2),  # half inside
        ("sheet", 0.5, 2, 0),
        ("sheet", 0.5, -0.25, None),
    ],
)
def test_open_bodies_that_are_dropped_are_counted(shape, side, offset, volume):
    piece = shifted({"cup": CUP, "sheet": SHEET}[shape].copy().apply_scale(side), offset, 0, 0.01)
    found = repair(together(box(), piece))
    assert found.mesh.volume == pytest.approx(1)
    assert found.dropped_bodies == (volume is not None)
    assert found.dropped_volume == pytest.approx((volume or 0) / (1 + (volume or 0)))


def test_what_was_dropped_is_said_in_words():
    assert dropped_text(0, 0.0) == ""
    assert dropped_text(1, 0.19) == "1 of 2 bodies was dropped, 19 % of the volume"
    assert dropped_text(1, 0.0) == "1 of 2 bodies was dropped, at most 10 % of the area"
    assert dropped_text(2, 0.005) == "2 of 3 bodies were dropped, 0.5 % of the volume"


def test_an_open_part_is_dropped_only_if_little_is_lost():
    mesh, *_ = repair(together(box(), shifted(CUP.copy().apply_scale(0.1), 2, 0, 0)))
    assert mesh.bounds == pytest.approx(box().bounds)
    with pytest.raises(RejectedError, match="open surface: 4 open edges"):
        repair(together(box(), shifted(CUP, 2, 0, 0)))


@pytest.mark.parametrize("inverted", [False, True])
def test_trapped_voids_are_filled_however_their_walls_wind(inverted):
    inner = icosphere(subdivisions=2, radius=0.3)
    if inverted:
        inner.invert()
    mesh, changed, *_ = repair(together(box(), inner))
    assert changed
    assert_sound(mesh)
    assert mesh.volume == pytest.approx(1)


def test_a_surface_that_runs_through_itself_is_untangled():
    tube = crossing_tube()
    assert tube.is_volume
    assert len(crossings(tube.vertices, tube.faces, 1e-6)) > 10
    mesh, changed, *_ = repair(tube)
    assert changed
    assert_sound(mesh)
    overlap = 0.12**3 * 16 / 3  # of two round tubes at a right angle; these meet at 90 degrees
    assert tube.volume - mesh.volume == pytest.approx(overlap, rel=0.1)


def test_untangling_leaves_the_rest_untouched():
    tube = crossing_tube()
    mesh = to_mesh(untangle(to_solid(tube.vertices, tube.faces)))
    far = tube.vertices[np.abs(tube.vertices[:, 0]) > 0.4]
    kept = {tuple(vertex) for vertex in mesh.vertices}
    assert all(tuple(vertex) in kept for vertex in far)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_unit_does_not_matter(size):
    mesh, *_ = repair(crossing_tube().apply_scale(size))
    assert_sound(mesh)


def test_repair_is_idempotent_and_deterministic():
    first, second = repair(crossing_tube()).mesh, repair(crossing_tube()).mesh
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.faces.tobytes() == second.faces.tobytes()
    again, changed, *_ = repair(first)
    assert not changed
    assert again.volume == pytest.approx(first.volume)


BAD = {
    "no faces": raw(np.zeros((3, 3)), np.empty((0, 3), dtype=int)),
    "not finite": raw([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]]),
    "no area": raw([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]),
    "open surface": SHEET,
    "no volume": together(SHEET, raw(SHEET.vertices, SHEET.faces[:, ::-1])),
}


@pytest.mark.parametrize("reason", BAD)
def test_what_bounds_no_solid_is_rejected_with_the_reason(reason):
    with pytest.raises(RejectedError, match=reason):
        repair(BAD[reason])


LIDLESS = raw(box().vertices, box().faces[2:])


@pytest.mark.parametrize("both_sides", [False, True])
@pytest.mark.parametrize("surface", [SHEET, LIDLESS])
def test_surfaces_without_thickness_are_rejected_with_the_advice_that_helps(surface, both_sides):
    other = raw(surface.vertices, surface.faces[:, ::-1])
    mesh = together(surface, other) if both_sides else surface
    with pytest.raises(RejectedError, match="`open_surfaces: thicken`"):
        repair(mesh)
    assert repair(mesh, "thicken", 0.05).mesh.is_watertight


def test_random_triangles_are_rejected_not_crashed_on():
    rng = np.random.default_rng(1)
    with pytest.raises(RejectedError):
        repair(raw(rng.normal(size=(60, 3)), rng.integers(0, 60, (200, 3))))
