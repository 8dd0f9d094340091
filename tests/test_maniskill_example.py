"""The ManiSkill task of `examples/maniskill`, if ManiSkill is installed: physics and the policy."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import trimesh
from scipy.spatial import ConvexHull

import egad

gym = pytest.importorskip("gymnasium")
pytest.importorskip("mani_skill")

EXAMPLE = Path(__file__).parents[1] / "examples/maniskill"
SIDES = (0.03, 0.04, 0.06)
DENSITY = 400  # kg/m3, as documented


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maniskill") / "objects"
    box = trimesh.creation.box(SIDES)
    box.apply_translation([0.01, 0.02, 0.03])
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.02)
    egad.export({"box": box, "ball": ball}, "urdf", "panda", folder, rule="none")
    return folder


@pytest.fixture(scope="module")
def env(folder):
    sys.path.insert(0, str(EXAMPLE))
    import pick_single_egad  # noqa: F401, PLC0415 (registers the task)

    env = gym.make(
        "PickSingleEGAD-v1",
        objects=folder,
        obs_mode="state",
        control_mode="pd_joint_pos",
        sim_backend="physx_cpu",
        render_backend="none",
    )
    yield env
    env.close()
    sys.path.remove(str(EXAMPLE))


def stand_still(env, steps):
    joints = env.unwrapped.agent.robot.get_qpos()[0, :8].numpy().copy()
    joints[7] = 1  # open
    for _ in range(steps):
        result = env.step(joints)
    return result


def test_mass_and_inertia_are_those_of_a_solid_box(env):
    env.reset(seed=0, options={"label": "box"})
    body = env.unwrapped.obj
    mass = DENSITY * np.prod(SIDES)
    squares = np.square(SIDES)
    assert body.mass[0] == pytest.approx(mass, rel=1e-5)
    moments = body._bodies[0].inertia
    np.testing.assert_allclose(
        np.sort(moments), np.sort(mass * (squares.sum() - squares) / 12), rtol=1e-4
    )
    np.testing.assert_allclose(body._bodies[0].cmass_local_pose.p, [0.01, 0.02, 0.03], atol=1e-6)


def test_hulls_in_the_simulator_are_as_large_as_the_convex_parts(env, folder):
    env.reset(seed=0, options={"label": "ball"})
    shapes = env.unwrapped.obj._bodies[0].collision_shapes
    files = sorted(folder.glob("ball/parts/*.obj"))
    assert len(shapes) == len(files) > 0
    for shape, file in zip(shapes, files, strict=True):
        part = trimesh.load_mesh(file).vertices / 1000  # the files are in millimetres
        planes = ConvexHull(shape.scale * shape.vertices).equations
        assert (planes[:, :3] @ part.T + planes[:, 3:]).max() < 5e-5


@pytest.mark.parametrize("pose", range(6))
def test_a_box_stays_in_each_stable_pose(env, pose):
    env.reset(seed=pose, options={"label": "box", "pose": pose})
    base = env.unwrapped
    before = base.obj.pose.to_transformation_matrix()[0].numpy().copy()
    height = base.object_center[0, 2].item()
    assert np.isclose(height, np.array(SIDES) / 2, atol=1e-5).any()  # it lies on a face
    stand_still(env, 10)
    after = base.obj.pose.to_transformation_matrix()[0].numpy()
    assert np.abs(after - before)[:3, 3].max() < 1e-3
    assert (after[:3, :3].T @ before[:3, :3]).trace() > 1 + 2 * np.cos(np.radians(2))


def test_same_seed_same_episode_and_labels_are_drawn(env):
    first, _ = env.reset(seed=3)
    label = env.unwrapped.objects[0].folder.name
    again, _ = env.reset(seed=3)
    np.testing.assert_array_equal(first.numpy(), again.numpy())
    assert env.unwrapped.objects[0].folder.name == label
    labels = set()
    for seed in range(6):
        env.reset(seed=seed)
        labels.add(env.unwrapped.objects[0].folder.name)
    assert labels == {"box", "ball"}


def test_success_is_the_center_of_mass_at_the_goal(env):
    env.reset(seed=1, options={"label": "box"})
    base = env.unwrapped
    assert not base.evaluate()["success"]
    pose = base.obj.pose.sp
    shift = (base.goal_site.pose.p - base.object_center)[0].numpy()
    pose.p = pose.p + shift
    base.obj.set_pose(pose)
    np.testing.assert_allclose(base.object_center, base.goal_site.pose.p, atol=1e-5)
    info = base.evaluate()
    assert info["success"]
    assert not info["is_grasped"]


def test_policy_lifts_a_box_to_the_goal(env, folder):
    from evaluate import attempt, report  # noqa: PLC0415
    from prepare import sample  # noqa: PLC0415

    grasps = egad.Grasps(sample(folder, 60))
    row = attempt(env, grasps, "box", seed=2)
    base = env.unwrapped
    assert row["outcome"] == "success"
    assert base.object_center[0, 2].item() > max(SIDES) / 2 + 0.07
    assert base.agent.is_grasping(base.obj)
    assert "1 of 1 episodes with 1 objects succeeded" in report(pd.DataFrame([row]))
    *_, info = stand_still(env, 20)  # the fingers open
    assert not info["success"]
    assert base.object_center[0, 2].item() < max(SIDES) / 2 + 0.03


def test_no_grasp_from_above_of_a_plate_wider_than_the_hand(env):  # noqa: ARG001 (the path)
    from policy import tcp_poses  # noqa: PLC0415

    plate = trimesh.creation.box([0.12, 0.12, 0.02])
    grasps = egad.sample_grasps(plate, "panda", n=60, seed=0)
    surface = trimesh.sample.sample_surface(plate, 2000, seed=0)[0]
    lying, standing = np.eye(4), trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    lying[2, 3], standing[2, 3] = 0.01, 0.06
    assert tcp_poses(grasps, lying, surface) == []
    found = tcp_poses(grasps, standing, surface)
    assert found
    for pose in found:
        assert abs(pose[1, 1]) > 0.7  # the fingers close across the plate
        assert pose[2, 2] < 0  # from above
