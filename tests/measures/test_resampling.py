import numpy as np
import pytest
import trimesh

import egad
from egad.errors import RejectedError
from egad.geometry import to_mesh, to_solid
from egad.geometry.repair import repair
from egad.measures.complexity import complexity
from egad.measures.resampling import map_complexity, resampled_complexity

RELEASED = egad.load("released")
TURN = trimesh.transformations.rotation_matrix(0.5, [1, 2, 3])


def noisy(mesh):
    """As a scan of an object 100 mm long, exact to 0.1 mm."""
    scan = mesh.subdivide()
    scan.vertices += np.random.default_rng(0).normal(0, 1e-4, scan.vertices.shape)
    return repair(scan).mesh


def decimated(mesh):
    """With about half of the vertices, and a surface up to 0.5 mm away."""
    solid = to_solid(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    fewer = to_mesh(solid.simplify(5e-4))
    assert len(fewer.vertices) < 0.6 * len(mesh.vertices)
    return fewer


COPIES = {
    "as released": lambda mesh: mesh,
    "noisy": noisy,
    "decimated": decimated,
}


@pytest.mark.parametrize("copy", COPIES)
@pytest.mark.parametrize("label", ["I04_1", "M14_3", "U18_1"])
def test_any_mesh_of_a_released_object_has_its_complexity(label, copy):
    mesh = RELEASED[label].mesh
    assert resampled_complexity(COPIES[copy](mesh)) == pytest.approx(complexity(mesh), abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("copy", COPIES)
def test_most_released_objects_are_recovered_from_copies(copy):
    chosen = np.random.default_rng(0).permutation(len(RELEASED))[:40]
    within = []
    for label in RELEASED.table["label"].iloc[chosen]:
        mesh = RELEASED[label].mesh
        within.append(abs(resampled_complexity(COPIES[copy](mesh)) - complexity(mesh)) <= 0.15)
    assert np.mean(within) >= (0.6 if copy == "decimated" else 0.85)


def test_an_object_that_is_few_voxels_long_is_recovered():
    assert np.ptp(np.argwhere(RELEASED["Y21_0"].voxels), axis=0).max() == 10
    mesh = RELEASED["Y21_0"].mesh
    assert resampled_complexity(mesh) == pytest.approx(complexity(mesh), abs=0.15)


def test_triangles_size_place_and_direction_of_a_cad_part_hardly_matter():
    part = trimesh.boolean.difference(
        [trimesh.creation.box([60, 60, 60]), trimesh.creation.cylinder(15, 80, sections=32)]
    )
    value = resampled_complexity(part)
    assert 1.2 < value < 3
    assert resampled_complexity(part.subdivide()) == pytest.approx(value, abs=0.16)
    moved = part.copy().apply_scale(0.01).apply_translation([5, 0, 0])
    assert resampled_complexity(moved) == pytest.approx(value, abs=0.01)
    assert resampled_complexity(part.copy().apply_transform(TURN)) == pytest.approx(value, abs=0.32)


def beaker(wall):
    outside = trimesh.creation.cylinder(35, 120, sections=64)
    inside = trimesh.creation.cylinder(35 - wall, 120, sections=64).apply_translation([0, 0, wall])
    return trimesh.boolean.difference([outside, inside])


def test_walls_that_are_thinner_than_a_voxel_do_not_crumble():
    values = [resampled_complexity(beaker(wall)) for wall in (0.5, 2, 4)]
    assert np.ptp(values) < 0.4
    plate = trimesh.creation.box([100, 60, 0.3]).apply_transform(TURN)
    assert 1 < resampled_complexity(plate) < 3  # 6.5 if voxels are solid by chance


def test_a_thin_fin_on_a_thick_block_does_not_crumble():
    block = trimesh.creation.box([60, 40, 30])
    fins = [trimesh.creation.box([wide, 40, 80]).apply_translation([0, 0, 40]) for wide in (1, 2)]
    values = [resampled_complexity(trimesh.boolean.union([block, fin])) for fin in fins]
    assert max(values) < 3.5  # 5 if walls are solid by chance


def test_the_triangles_of_a_regular_grid_are_not_those_of_evolved_objects():
    cube = trimesh.creation.box([1, 1, 1])
    for _ in range(5):
        cube = cube.subdivide()
    assert complexity(cube) < 0.05
    assert map_complexity(cube) == pytest.approx(1.23, abs=0.05)


def test_a_cube_has_that_of_a_solid_of_voxels():
    cube = trimesh.creation.box([1, 1, 1])
    assert complexity(cube) == 0
    assert resampled_complexity(cube) == pytest.approx(1.23, abs=0.02)


def test_vertices_without_faces_do_not_count():
    ball = trimesh.creation.icosphere(3)
    more = trimesh.Trimesh([*ball.vertices, [9, 9, 9]], ball.faces, process=False)
    assert resampled_complexity(more) == resampled_complexity(ball)


def test_nothing_has_no_complexity():
    with pytest.raises(RejectedError):
        resampled_complexity(trimesh.Trimesh())
