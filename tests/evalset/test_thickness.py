import manifold3d
import numpy as np
import pytest
import trimesh

from egad.evalset.printability import thinness
from egad.geometry.manifold import to_mesh

BALL = 1.2


def box(*sides):
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
    found = thinness(box(20, 20, 20), BALL)
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
    found = thinness(box(20, 20, thick), BALL)
    assert min(found.edge, found.wall) > 5


def test_a_square_rod_as_thick_as_the_ball_is_reached_all_along():
    for seed in range(3):
        found = thinness(turned(box(1.25, 1.25, 30), seed), BALL)
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
    cube = box(20, 20, 20)
    faces = np.vstack([cube.faces, [[0, 0, 1]]])
    broken = trimesh.Trimesh(cube.vertices, faces, process=False)
    assert thinness(broken, BALL).edge == pytest.approx(thinness(cube, BALL).edge)
