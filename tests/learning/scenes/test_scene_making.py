"""Labelled scenes: what cameras see, where grasps are tried, and what their labels say."""

import io

import numpy as np
import pandas as pd
import pytest
import trimesh
from PIL import Image
from scipy.spatial.transform import Rotation
from small_scenes import BOXES, SPLIT_OF, parameters

from egad.bench import RestingObject, SceneCameras, put
from egad.detectors import Intrinsics
from egad.geometry import Bundle, nearest
from egad.grippers import as_gripper, finger_span
from egad.learning.images import pose_matrix
from egad.learning.scenes import make_scene, planned_scenes
from egad.learning.scenes.making import (
    hand_poses_at,
    middle_of_run,
    nearest_objects,
    sample_points,
    try_yaws,
)
from egad.sim import ContactRules, Pose, build, execute_pose, free_hand, open_world
from egad.tables.columns import POSE_PARTS

PANDA = as_gripper("panda")


def placements(row):
    return [pose_matrix(each) for each in np.reshape(row["placements"], (-1, 7))]


def test_masks_show_each_object_where_it_lies(made):
    """The middle of a row of pixels of an object lies on the surface of its box."""
    clear = [each.scene for each in made if each.scene["noise"] == "none"]
    assert {(row["kind"], len(row["objects"]) > 1) for row in clear} >= {
        ("packed", True),
        ("pile", True),
    }
    for row in clear:
        intrinsics = Intrinsics(
            row["width"], row["height"], row["focal"], (row["center_u"], row["center_v"])
        )
        cameras = np.reshape(row["cameras"], (-1, 7))
        assert len(cameras) == len(row["depth"]) == len(row["mask"]) == 6
        for camera, depth, mask in zip(cameras, row["depth"], row["mask"], strict=True):
            pixels = np.asarray(Image.open(io.BytesIO(mask)))
            depths = np.asarray(Image.open(io.BytesIO(depth))) * 1e-4
            seen = intrinsics.rays() * depths[..., None]
            matrix = pose_matrix(camera)
            world = seen @ matrix[:3, :3].T + matrix[:3, 3]
            assert pixels.max() == len(row["objects"])
            for number, placement in enumerate(placements(row)):
                mesh = BOXES[row["objects"][number]].copy()
                mesh.apply_scale(row["factors"][number]).apply_transform(placement)
                points = world[pixels == number + 1]
                assert np.abs(nearest(points, mesh)[0]).max() < 5e-4
            assert np.abs(world[(pixels == 0) & (depths > 0)][:, 2]).max() < 5e-4


def test_a_labelled_grasp_has_the_same_outcome_when_it_is_tried_alone(made, plan, models):
    """In a world of its own, whatever was tried before; the width is that of the held box."""
    checked = held = 0
    for each, planned in zip(made, plan, strict=True):
        row = each.scene
        sized = [
            models[name].scaled(by) for name, by in zip(row["objects"], row["factors"], strict=True)
        ]
        present = []
        for number, (model, placement) in enumerate(zip(sized, placements(row), strict=True)):
            scaled = placement @ np.diag([row["factors"][number]] * 3 + [1.0])
            matrix = scaled @ np.linalg.inv(model.to_principal)
            turn = Rotation.from_matrix(matrix[:3, :3]).as_quat()
            present.append(RestingObject(number, Pose(matrix[:3, 3], turn)))
        for grasp in each.grasps.to_dict("records")[:4]:
            pose = pose_matrix(np.array([grasp[name] for name in POSE_PARTS]))
            walls = 0.26 if planned.round.scene == "pile" else None
            with open_world("mujoco", sized, free_hand(PANDA), walls) as world:
                put(world, present)
                found = execute_pose(world, pose, PANDA.opening, ContactRules("collided"))
                assert found.outcome == grasp["outcome"]
                assert (found.outcome == "success") == grasp["success"]
                if grasp["success"]:
                    width = float(world.fingers()[0].sum())
                    assert grasp["width"] == pytest.approx(width, abs=1e-4)
                    held += 1
                for k in (1, 2):
                    turn = trimesh.transformations.rotation_matrix(np.pi * k / 3, [0, 0, 1])
                    put(world, present)
                    other = execute_pose(
                        world, pose @ turn, PANDA.opening, ContactRules("collided")
                    )
                    assert (other.outcome == "success") == grasp["yaws"][k]
            checked += 1
    assert checked == 16
    assert held > 0


def test_the_same_scene_is_made_again(made, plan, models, settings):
    last = make_scene(plan[-1], models, settings)
    assert last.scene == made[-1].scene
    pd.testing.assert_frame_equal(last.grasps, made[-1].grasps)


@pytest.fixture
def standing():
    """A box, 30 x 90 x 50 mm, alone in the middle of the table."""
    box = trimesh.creation.box([0.03, 0.09, 0.05])
    model = build(box, 300.0, Bundle())
    matrix = np.linalg.inv(model.to_principal)
    pose = Pose(matrix[:3, 3] + [0, 0, 0.025], Rotation.from_matrix(matrix[:3, :3]).as_quat())
    with open_world("mujoco", [model], free_hand(PANDA)) as world:
        yield world, [RestingObject(0, pose)]


@pytest.mark.parametrize(
    ("point", "normal", "below", "held"),
    [
        ((0, 0, 0.05), (0, 0, 1), 0.02, True),  # from above, across the narrow side
        ((0, 0, 0.05), (0, 0, 1), -0.004, False),  # closes above it
        ((0, 0, 0.05), (0, 0, 1), 0.048, False),  # the palm would be in it
        ((0, 0.045, 0.04), (0, 1, 0), 0.02, True),  # from its end
        ((0.015, 0, 0.005), (1, 0, 0), 0.02, False),  # the hand would be in the table
    ],
)
def test_a_box_is_held_across_its_faces(standing, point, normal, below, held):
    world, present = standing
    settings = parameters(yaws=4)
    tip = finger_span(PANDA)[1]
    rng = np.random.default_rng(0)
    poses = hand_poses_at(np.array([point], float), np.array([normal], float), settings, rng)[0]
    poses[:, :3, 3] = np.array(point) - (below - tip) * np.array(normal)
    level = np.array([1.0, 0, 0]) if normal[0] == 0 else np.array([0, 1.0, 0])
    across = np.cross(poses[0, :3, 2], level)
    for number, pose in enumerate(poses):
        angle = np.pi * number / 4
        pose[:3, 0] = np.cos(angle) * level + np.sin(angle) * across
        pose[:3, 1] = np.cross(pose[:3, 2], pose[:3, 0])
    tried = try_yaws(world, present, poses, settings)
    assert any(tried.yaws) == tried.yaws[0] == held
    assert len(tried.yaws) == 4
    if held:
        assert tried.outcome == "success"
        assert abs(tried.pose[0, 0]) > 0.9  # closes along x, the narrow side
        assert tried.width == pytest.approx(0.03, abs=0.004)
    else:
        assert np.isnan(tried.width)
        np.testing.assert_array_equal(tried.pose, poses[0])


def test_poses_come_against_the_normal_evenly_over_half_a_turn():
    rng = np.random.default_rng(5)
    normals = rng.normal(size=(200, 3))
    normals[:3] = np.eye(3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = rng.uniform(-0.1, 0.1, size=(200, 3))
    poses = hand_poses_at(points, normals, parameters(yaws=5), rng)
    assert poses.shape == (200, 5, 4, 4)
    rotations = poses[..., :3, :3]
    np.testing.assert_allclose(
        rotations @ rotations.swapaxes(-1, -2),
        np.broadcast_to(np.eye(3), rotations.shape),
        atol=1e-9,
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1)
    for yaw in range(5):
        np.testing.assert_allclose(poses[:, yaw, :3, 2], -normals, atol=1e-12)
        between = np.einsum("nk,nk->n", poses[:, 0, :3, 0], poses[:, yaw, :3, 0])
        np.testing.assert_allclose(between, np.cos(np.pi * yaw / 5), atol=1e-9)
    base, tip = finger_span(PANDA)
    tips = poses[..., :3, 3] + tip * poses[..., :3, 2]
    below = np.einsum("nyk,nk->ny", points[:, None] - tips, normals)
    np.testing.assert_allclose(tips, points[:, None] - below[..., None] * normals[:, None])
    low, high = below.min() / (tip - base), below.max() / (tip - base)
    assert 0.1 <= low < 0.15 < 1.05 < high <= 1.1


@pytest.mark.parametrize(
    ("flags", "middle"),
    [
        ("00100", 2),
        ("01111", 2),
        ("10011", 4),  # over the end: 3, 4, 0
        ("10100", 0),  # of equal runs the first
        ("11111", 2),
        ("0", 0),
    ],
)
def test_the_middle_of_the_widest_run(flags, middle):
    assert middle_of_run([flag == "1" for flag in flags]) == middle


def test_points_do_not_look_down():
    rng = np.random.default_rng(2)
    points = rng.uniform(size=(500, 3))
    normals = rng.normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    chosen, directions = sample_points(points, normals, 300, rng)
    assert len(chosen) == 300
    assert directions[:, 2].min() > -0.1
    rows = [np.flatnonzero((points == point).all(axis=1))[0] for point in chosen]
    np.testing.assert_array_equal(normals[rows], directions)
    nothing, _ = sample_points(points, np.tile([0, 0, -1.0], (500, 1)), 300, rng)
    assert nothing.shape == (0, 3)


def test_points_belong_to_the_nearest_object(standing, made):
    """Of two boxes side by side."""
    world, (present,) = standing
    aside = Pose(np.add(present.pose.position, [0.1, 0, 0]), present.pose.quaternion)
    both = [present, RestingObject(0, aside)]
    points = np.array([[0.015, 0, 0.02], [0.085, 0, 0.02], [0.049, 0, 0.02], [0.1, 0, 0.05]])
    assert nearest_objects(points, world, both) == [0, 1, 0, 1]
    for each in made:
        ids = each.scene["objects"]
        assert list(each.grasps["id"]) == [ids[number] for number in each.grasps["object"]]
    assert nearest_objects(np.empty((0, 3)), None, []) == []


def test_protocols_have_their_rules(models):
    """Scenes of another lineage: its scales, and cameras of one's own."""
    settings = parameters(
        scenes=1, validation=0, test=0, protocol="vgn", cameras={"views": 2, "image": [64, 48]}
    )
    (planned,) = planned_scenes(SPLIT_OF, settings)
    found = make_scene(planned, models, settings)
    assert len(found.scene["depth"]) == 2
    assert (found.scene["width"], found.scene["height"]) == (64, 48)
    assert all(0.7 <= factor <= 1.0 for factor in found.scene["factors"])
    assert settings.clutter.clutter.protocol.cameras == SceneCameras(views=2, image=(64, 48))
