import manifold3d
import numpy as np
import pytest
import trimesh

from egad.evalset import PrintCheck
from egad.evalset.printability import print_problems, shell_volumes, thinness
from egad.geometry.manifold import to_mesh

CHECK = PrintCheck(wall=0.0012, blunting=0.0015)
THIN = ["walls thinner than 1.2 mm"]
JOINED = ["parts joined by less than 1.2 mm"]


def box(*sides):
    return trimesh.creation.box(extents=0.001 * np.array(sides))


def block(low, high):
    """A box between two corners, millimetres."""
    return manifold3d.Manifold.cube(np.subtract(high, low).tolist()).translate(low)


def solid(manifold):
    return to_mesh(manifold.scale((0.001, 0.001, 0.001)))


def dumbbell(length, neck):
    """Two cubes joined by a square bar."""
    far, half = 20 + length, neck / 2
    bar = block((19, 10 - half, 10 - half), (far + 1, 10 + half, 10 + half))
    return solid(block((0, 0, 0), (20, 20, 20)) + block((far, 0, 0), (far + 20, 20, 20)) + bar)


def fin(thick, high):
    """A cube with a fin on top, all along."""
    return solid(block((0, 0, 0), (30, 30, 30)) + block((14, 0, 29), (14 + thick, 30, 30 + high)))


def film(thick, across, along):
    """A cube with a hole through it, closed by a film halfway."""
    x, y, z = across / 2, along / 2, thick / 2
    hole = block((10 - x, 10 - y, -1), (10 + x, 10 + y, 21))
    return solid(block((0, 0, 0), (20, 20, 20)) - (hole - block((0, -1, 10 - z), (20, 21, 10 + z))))


def placed(mesh):
    """The mesh moved along and turned."""
    for shift in (0, 0.0005):
        yield mesh.copy().apply_translation([shift] * 3)
    random = np.random.default_rng(0).random(3)
    yield mesh.copy().apply_transform(trimesh.transformations.random_rotation_matrix(random))


@pytest.mark.parametrize("thick", [0.5, 1.0, 1.15, 1.25, 2.0])
def test_a_plate_passes_from_the_thinnest_wall_on(thick):
    assert print_problems(box(30, 25, thick), CHECK) == ([] if thick >= 1.2 else THIN)


def test_a_turned_and_finely_cut_plate_is_as_thin_as_before():
    plate = box(30, 25, 1.1).subdivide().subdivide()
    plate.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3]))
    assert print_problems(plate, CHECK) == THIN


def test_edges_and_tips_are_no_walls():
    for half, passes in ((45, True), (30, True), (20, True), (14, False), (8, False)):
        angle = np.radians(half)
        cone = trimesh.creation.cone(radius=0.03 * np.tan(angle), height=0.03, sections=64)
        assert (print_problems(cone, CHECK) == []) == passes


@pytest.mark.parametrize("neck", [0.2, 1.1, 1.3])
@pytest.mark.parametrize("length", [0.3, 1.0, 3.0])
def test_a_neck_is_found_wherever_the_object_lies(length, neck):
    wrong = [] if neck >= 1.2 else THIN if length == 3 else JOINED
    for mesh in placed(dumbbell(length, neck)):
        assert print_problems(mesh, CHECK) == wrong


@pytest.mark.parametrize("core", [0.5, 1.1, 1.3])
@pytest.mark.parametrize("width", [0.01, 0.3])
def test_the_core_left_by_a_groove_all_round_is_measured(width, core):
    low, high = 10 - core / 2, 10 + core / 2
    slice_ = block((10 - width / 2, -1, -1), (10 + width / 2, 21, 21))
    groove = slice_ - block((0, low, low), (20, high, high))
    for mesh in placed(solid(block((0, 0, 0), (20, 20, 20)) - groove)):
        assert print_problems(mesh, CHECK) == ([] if core >= 1.2 else JOINED)


@pytest.mark.parametrize(
    ("thick", "high", "wrong"),
    [
        (0.1, 0.5, []),
        (0.1, 1.5, THIN),
        (1.0, 3, THIN),
        (1.15, 3, THIN),
        (1.25, 8, []),
        (1.5, 3, []),
    ],
)
def test_a_fin_is_a_wall_from_half_a_wall_on(thick, high, wrong):
    assert print_problems(fin(thick, high), CHECK) == wrong


@pytest.mark.parametrize("thick", [0.001, 1.0])
def test_a_film_between_thick_parts_is_found(thick):
    for mesh in placed(film(thick, 3.5, 3.5)):
        assert print_problems(mesh, CHECK) == THIN
    for mesh in placed(film(thick, 0.3, 30)):  # the cube is in two halves
        assert print_problems(mesh, CHECK) == JOINED


@pytest.mark.parametrize("across", [0.3, 3.5])
def test_a_thick_bridge_is_no_film(across):
    for along in (across, 30):
        assert print_problems(film(1.3, across, along), CHECK) == []


def test_a_trapped_void_is_found():
    cavity = box(8, 8, 8)
    cavity.invert()
    hollow = trimesh.util.concatenate([box(20, 20, 20), cavity])
    assert shell_volumes(hollow) == pytest.approx([8e-6, -0.512e-6])
    assert print_problems(hollow, CHECK) == ["1 trapped void"]


def test_an_open_surface_is_not_closed():
    cut = box(20, 20, 20)
    cut.update_faces(np.arange(12) > 0)
    assert print_problems(cut, CHECK) == ["not closed"]


def test_a_surface_wound_inwards_is_called_so():
    cube = box(20, 20, 20)
    cube.invert()
    assert print_problems(cube, CHECK) == ["wound inwards"]


BALL = 1.2


def sized_box(*sides):
    return trimesh.creation.box(extents=sides)


def prism(angle):
    """An upright edge of an angle in degrees, 30 high and 20 long, with the other two wider."""
    half = 30 * np.tan(np.radians(angle) / 2)
    return to_mesh(
        manifold3d.Manifold.extrude(manifold3d.CrossSection([[(0, 30), (-half, 0), (half, 0)]]), 20)
    )


def turned(mesh, seed):
    rng = np.random.default_rng(seed)
    matrix = trimesh.transformations.random_rotation_matrix(rng.random(3))
    matrix[:3, 3] = rng.random(3) * 50
    return mesh.copy().apply_transform(matrix)


def test_a_right_angled_edge_loses_a_fifth_of_the_diameter():
    found = thinness(sized_box(20, 20, 20), BALL)
    assert 0.15 * BALL < found.edge < 0.37 * BALL  # a corner: (sqrt(3) - 1) / 2
    assert (found.wall, found.part) == (0, 0)


def test_a_smooth_body_loses_nothing():
    found = thinness(trimesh.creation.icosphere(subdivisions=4, radius=4), BALL)
    assert found == pytest.approx((0, 0, 0), abs=0.01)


@pytest.mark.parametrize("angle", [16, 24, 32, 40])
def test_sharp_edges_are_parallel_walls_below_thirty_degrees(angle):
    lost = BALL * (1 / np.sin(np.radians(angle) / 2) - 1) / 2
    found = thinness(prism(angle), BALL)
    assert found.edge == pytest.approx(lost, rel=0.15)
    assert found.wall == (pytest.approx(found.edge) if angle < 30 else 0)


@pytest.mark.parametrize("thick", [0.001, 0.02, 0.5, 1.15, 1.19])
def test_no_ball_fits_a_thin_plate(thick):
    found = thinness(sized_box(20, 20, thick), BALL)
    assert min(found.edge, found.wall) > 5


def test_a_square_rod_as_thick_as_the_ball_is_reached_all_along():
    for seed in range(3):
        found = thinness(turned(sized_box(1.25, 1.25, 30), seed), BALL)
        assert found.edge < 0.4
        assert (found.wall, found.part) == (0, 0)


def plate(thick, parts):
    """A plate of 20 x 20, its top in parts x parts squares, its bottom in two triangles."""
    side = np.linspace(0, 20, parts + 1)
    x, y = np.meshgrid(side, side, indexing="ij")
    top = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, thick)])
    grid = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        each.ravel() for each in (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    )
    low = len(top) + np.arange(4)
    faces = [np.column_stack([a, b, c]), np.column_stack([a, c, d]), low[[[0, 2, 1], [0, 3, 2]]]]
    for corner, rim in enumerate((grid[:, 0], grid[-1], grid[::-1, -1], grid[0, ::-1])):
        start, end = low[corner], low[(corner + 1) % 4]
        fan = np.column_stack([np.full(parts, start), rim[1:], rim[:-1]])
        faces += [fan, [[start, end, rim[-1]]]]
    bottom = [[0, 0, 0], [20, 0, 0], [20, 20, 0], [0, 20, 0]]
    return trimesh.Trimesh(np.vstack([top, bottom]), np.vstack(faces), process=False)


@pytest.mark.parametrize("parts", [1, 10, 40])
def test_a_plate_is_as_thin_however_its_sides_are_meshed(parts):
    assert plate(1.15, parts).is_volume
    assert thinness(plate(1.15, parts), BALL).edge == np.inf
    assert thinness(plate(1.25, parts), BALL).edge < 0.4


def test_a_mesh_with_triangles_without_area_is_measured():
    cube = sized_box(20, 20, 20)
    faces = np.vstack([cube.faces, [[0, 0, 1]]])
    broken = trimesh.Trimesh(cube.vertices, faces, process=False)
    assert thinness(broken, BALL).edge == pytest.approx(thinness(cube, BALL).edge)
