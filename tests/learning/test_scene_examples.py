"""From labelled scenes to examples: voxels, rotations, moves, and the order of a stream."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from shapes import ShapeScenes, look_at_a_box

from egad.detectors import DepthCamera, Intrinsics, Tsdf, cameras_around, fuse
from egad.grippers import GRIPPERS, finger_span
from egad.learning.scene_examples import (
    Move,
    NetworkGrasps,
    SceneStream,
    labelled_grasps,
    scene_example,
)

HAND = GRIPPERS["panda"]
CAMERA = Intrinsics(320, 240, 208.0, (159.5, 119.5))
CORNER = np.array([-0.15, -0.15, -0.05])
QUARTER = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])


def empty_field(side=40):
    voxel = 0.3 / side
    values = np.zeros((side,) * 3, np.float32)
    return Tsdf(values, np.ones_like(values), CORNER, voxel, 4 * voxel)


def sampled_poses(count, seed=0):
    rng = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, rng).as_matrix()
    poses[:, :3, 3] = rng.uniform([-0.1, -0.1, -0.03], [0.1, 0.1, 0.2], (count, 3))
    return poses


def grasps_at(poses):
    ones = np.ones(len(poses), np.float32)
    return NetworkGrasps(poses, ones, 0.04 * ones, np.ones((len(poses), 1), bool))


class OneScene:
    def __init__(self, poses, success, width):
        self.poses = poses
        yaws = [[each] for each in success]
        self.grasps = pd.DataFrame({"success": success, "width": width, "yaws": yaws})


def test_a_grasp_becomes_a_voxel_a_rotation_and_a_width():
    """By hand: VGN's y is our x, and its origin is 5 cm before the fingertips."""
    poses = sampled_poses(30)
    poses[0, :3, 3] = [0.2, 0, 0.1]  # beside the cube
    grasps = labelled_grasps(OneScene(poses, [True] * 30, [0.03] * 30), HAND)
    example = scene_example(empty_field(), grasps)
    tips = poses[:, :3, 3] + finger_span(HAND)[1] * poses[:, :3, 2]
    origins = tips - 0.05 * poses[:, :3, 2]
    voxels = np.array(
        [[round(number) for number in place] for place in (origins - CORNER) / 0.0075]
    )
    inside = ((voxels >= 0) & (voxels < 40)).all(axis=1)
    assert 0 < inside.sum() < 30
    np.testing.assert_array_equal(example.voxels, voxels[inside])
    for pose, both in zip(poses[inside], example.rotations, strict=True):
        one, other = (Rotation.from_quat(each).as_matrix() for each in both)
        for turned, sign in ((one, 1), (other, -1)):
            np.testing.assert_allclose(turned[:, 1], sign * pose[:3, 0], atol=1e-6)
            np.testing.assert_allclose(turned[:, 2], pose[:3, 2], atol=1e-6)
    np.testing.assert_allclose(example.widths, 4, rtol=1e-6)
    assert example.voxel == 0.0075


def test_every_yaw_that_holds_is_a_right_answer_and_no_other():
    """Of five yaws 36 degrees apart, the first, second and fourth hold."""
    poses = sampled_poses(20)
    grasps = grasps_at(poses)._replace(yaws=np.tile([True, True, False, True, False], (20, 1)))
    example = scene_example(empty_field(), grasps)
    assert example.rotations.shape == (20, 10, 4)
    right = {round(angle) % 360 for angle in (0, 36, 108, 180, 216, 288)}
    for pose, answers in zip(poses, example.rotations, strict=True):
        turns = Rotation.from_matrix(pose[:3, :3]).inv() * Rotation.from_quat(answers)
        x, y, z = turns.as_rotvec(degrees=True).T
        np.testing.assert_allclose([x, y], 0, atol=1e-4)
        assert set(np.round(z).astype(int) % 360) == right


def test_grasps_outside_the_cube_are_left_out_and_those_at_its_sides_are_not():
    poses = np.tile(np.eye(4), (6, 1, 1))
    places = [[0, 0, 0], [39.4, 39.4, 39.4], [-0.4, 5, 5], [39.6, 5, 5], [5, -0.6, 5], [5, 5, 40]]
    poses[:, :3, 3] = CORNER + 0.0075 * np.array(places)
    example = scene_example(empty_field(), grasps_at(poses))
    assert example.voxels.tolist() == [[0, 0, 0], [39, 39, 39], [0, 5, 5]]
    assert len(example.success) == len(example.rotations) == len(example.widths) == 3


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_turning_a_scene_is_turning_its_objects_cameras_and_hands(turns):
    """The oracle turns the mesh, and looks again."""
    mesh = trimesh.creation.box((0.03, 0.1, 0.06)).apply_translation((0.04, 0.02, 0.03))
    cameras = cameras_around(np.array([0, 0, 0.0]), 3, 0.6, np.radians(30), 0.3)
    turn = np.linalg.matrix_power(QUARTER, turns)

    def seen(by):
        eye = DepthCamera(mesh.copy().apply_transform(by))
        views = [eye.render(np.eye(4), CAMERA, by @ camera) for camera in cameras]
        return fuse(views, CORNER, 0.3, 40)

    poses = sampled_poses(30)
    moved = scene_example(seen(np.eye(4)), grasps_at(poses), Move(turns))
    again = scene_example(seen(turn), grasps_at(turn @ poses))
    assert (np.abs(moved.grid - again.grid) < 1e-3).mean() > 0.999  # but for pixels at edges
    assert (again.grid > 0).mean() > 0.05
    np.testing.assert_array_equal(moved.voxels, again.voxels)
    near = np.abs((moved.rotations * again.rotations).sum(axis=2))
    np.testing.assert_allclose(near, 1, atol=1e-6)


@pytest.mark.parametrize("rise", [-3, 4])
def test_raising_a_scene_moves_grid_and_grasps_alike(rise):
    """A marked voxel stays at its grasp; what is lifted out of the cube is lost."""
    field = empty_field()
    field.distances[:] = 1  # far from any surface, so 0 when encoded
    places = np.array([[5, 6, 7], [30, 8, 2], [9, 9, 37], [20, 20, 20]])
    field.distances[tuple(places.T)] = [0.2, 0.4, 0.6, 0.8]
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[:, :3, 3] = CORNER + 0.0075 * places
    example = scene_example(field, grasps_at(poses), Move(0, rise))
    kept = [k for k in range(4) if 0 <= places[k, 2] + rise < 40]
    np.testing.assert_array_equal(example.voxels, places[kept] + [0, 0, rise])
    values = example.grid[tuple(example.voxels.T)]
    np.testing.assert_allclose(values, [[0.6, 0.7, 0.8, 0.9][k] for k in kept])
    assert np.count_nonzero(example.grid) == len(kept)


class TestStream:
    def test_a_pass_shows_each_training_scene_once(self):
        scenes = ShapeScenes(10, 3)
        shown = []
        scenes.scene = lambda number, scene=scenes.scene: (
            shown.append(int(number)),
            scene(number),
        )[1]
        stream = SceneStream(scenes, HAND, 12)
        for number in range(12):
            stream[number]
        assert sorted(shown[:6]) == sorted(shown[6:]) == scenes.indices("train").tolist()
        with pytest.raises(IndexError):
            stream[12]

    def test_some_of_the_scenes_are_drawn_anew_for_each_seed(self):
        scenes = ShapeScenes(10, 20)
        found = [
            tuple(SceneStream(scenes, HAND, 4, seed=seed, most=4).index.index) for seed in range(5)
        ]
        assert all(len(each) == 4 and set(each) <= set(scenes.indices("train")) for each in found)
        assert len(set(found)) > 1
        everything = SceneStream(scenes, HAND, 4, most=99)
        assert everything.index.index.tolist() == scenes.indices("train").tolist()

    def test_an_example_depends_on_seed_and_number_alone(self):
        scenes = ShapeScenes(10, 20)
        forth = [SceneStream(scenes, HAND, 40, 2, seed=1)[number] for number in (0, 20, 39)]
        stream = SceneStream(scenes, HAND, 40, 2, seed=1)
        for number, first in zip((39, 20, 0), forth[::-1], strict=True):
            again = stream[number]
            for one, other in zip(first, again, strict=True):
                np.testing.assert_array_equal(one, other)
        other = SceneStream(scenes, HAND, 40, 2, seed=2)
        assert any(not np.array_equal(stream[n].grid, other[n].grid) for n in range(3))

    def test_noise_is_added_to_some_examples_of_scenes_without_any(self):
        """The oracle is the same stream without noise."""
        scenes = look_at_a_box(ShapeScenes(5, 3))
        clear = SceneStream(scenes, HAND, 24)
        noisy = SceneStream(scenes, HAND, 24, noise=("none", "dex"))
        shown = [noisy._passes[number] for number in range(24)]
        same = [np.array_equal(clear[n].grid, noisy[n].grid) for n in range(24)]
        assert all(equal for equal, number in zip(same, shown, strict=True) if number == 1)
        others = [equal for equal, number in zip(same, shown, strict=True) if number != 1]
        assert 4 <= sum(others) <= 12
        np.testing.assert_array_equal(clear[5].voxels, noisy[5].voxels)

    def test_views_turns_and_heights_are_all_seen(self, monkeypatch):
        """One camera, two or all three, any of them, each number of them about as often."""
        scenes, asked, moves = ShapeScenes(5, 3), [], []
        shown = type(scenes.scene(0))
        observation = shown.observation
        monkeypatch.setattr(
            shown, "observation", lambda self, views: (asked.append(views), observation(self))[1]
        )
        monkeypatch.setattr(
            "egad.learning.scene_examples.moved_grid",
            lambda grid, move: (moves.append(move), grid)[1],
        )
        stream = SceneStream(scenes, HAND, 240, 2)
        for number in range(240):
            stream[number]
        assert {tuple(views) for views in asked} == {
            *((0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2))
        }
        counts = np.bincount([len(views) for views in asked])
        assert (counts[1:] > 55).all()
        assert {move.turns for move in moves} == {0, 1, 2, 3}
        assert {move.rise for move in moves} == {-2, -1, 0, 1, 2}
