import numpy as np
import pytest

from egad.evolution import Neat, Symmetry
from egad.evolution import query as cppn
from egad.evolution.constraints import folded, is_whole, turned
from egad.evolution.genome import neat_config, random_genome

CONFIG = neat_config(Neat(initial_connections=1.0))


def field(seed, resolution, **symmetry):
    return cppn.query(random_genome(CONFIG, seed), resolution, Symmetry(**symmetry))


@pytest.mark.parametrize("resolution", [8, 25])
@pytest.mark.parametrize("axes", [("x",), ("y", "z"), ("x", "y", "z")])
@pytest.mark.parametrize("fold", [1, 3, 4])
def test_mirrored_points_get_the_same_output_to_the_last_bit(resolution, axes, fold):
    for seed in range(3):
        output = field(seed, resolution, mirror=axes, fold=fold)
        for axis in axes:
            assert np.array_equal(output, np.flip(output, "xyz".index(axis)))


@pytest.mark.parametrize(("axis", "plane"), [("x", (1, 2)), ("y", (2, 0)), ("z", (0, 1))])
@pytest.mark.parametrize("mirror", [(), ("x",), ("x", "y")])
def test_quarter_turns_do_not_change_the_output(axis, plane, mirror):
    output = field(1, 15, fold=4, axis=axis, mirror=mirror)
    np.testing.assert_allclose(output, np.rot90(output, axes=plane), atol=1e-4)


@pytest.mark.parametrize("fold", [2, 3, 5, 6])
@pytest.mark.parametrize("mirror", [(), ("x",), ("y",), ("x", "y"), ("z", "y")])
def test_points_a_fold_of_a_turn_apart_become_one(fold, mirror):
    points = np.random.default_rng(0).uniform(-0.7, 0.7, (3, 50))
    angle = 2 * np.pi / fold
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    other = np.vstack([turn @ points, points[2:]])
    symmetry = Symmetry(fold=fold, mirror=mirror)
    np.testing.assert_allclose(folded(points, symmetry), folded(other, symmetry), atol=2e-5)


def test_a_shape_may_be_twisted_and_is_otherwise_free():
    output = field(1, 15, fold=4)
    assert not np.allclose(output, np.flip(output, 0))
    assert not np.allclose(output, np.flip(output, 2))


def test_without_symmetry_the_inputs_are_those_of_the_grid():
    assert np.array_equal(cppn.grid_inputs(9), cppn.grid_inputs(9, Symmetry()))
    kept = [2, 3, 6]  # height, and the distances from the axis and from the middle
    turned_inputs = cppn.grid_inputs(9, Symmetry(fold=2))
    np.testing.assert_allclose(turned_inputs[kept], cppn.grid_inputs(9)[kept], atol=1e-6)


def test_one_of_two_mirror_images_is_not_whole():
    voxels = np.zeros((9, 9, 9), dtype=bool)
    voxels[1:3, 3:6, 3:6] = True
    assert not is_whole(voxels, Symmetry(mirror=("x",)))
    assert not is_whole(voxels, Symmetry(fold=3))
    assert is_whole(voxels, Symmetry(mirror=("y", "z")))
    assert is_whole(voxels | np.flip(voxels, 0), Symmetry(mirror=("x",), fold=2))


def test_a_quarter_turn_of_voxels_is_exact():
    voxels = np.random.default_rng(1).random((7, 7, 7)) < 0.3
    assert np.array_equal(turned(voxels, Symmetry(fold=4)), np.rot90(voxels, axes=(0, 1)))
