import json

import numpy as np
import pytest
import trimesh
import yaml

import egad
from egad.errors import UserError
from egad.exchange.export import export_grasps
from egad.exchange.grasps.graspgen_suction import start_suction, write_suction
from egad.grasps.suction import sample_suction, suction_poses

BOX = trimesh.creation.box((0.07, 0.08, 0.09))
BALL = trimesh.creation.icosphere(subdivisions=4, radius=0.04)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("set") / "suction"
    hand = egad.gripper("cup_30mm")
    egad.export({"box": BOX, "ball": BALL}, "graspgen_suction", hand, out, grasps=30, rule="none")
    return out


def read(folder, label):
    (path,) = folder.glob(f"grasp_data/*/{label}.json")
    return json.loads(path.read_text())


def test_poses_stand_on_the_surface_and_look_outwards(folder):
    grasps = read(folder, "ball")["grasps"]
    poses = np.array(grasps["transforms"])
    turns, places = poses[:, :3, :3], poses[:, :3, 3]
    np.testing.assert_allclose(
        turns @ turns.transpose(0, 2, 1), np.tile(np.eye(3), (30, 1, 1)), atol=1e-8
    )
    np.testing.assert_allclose(np.linalg.det(turns), 1)
    outwards = places / np.linalg.norm(places, axis=1, keepdims=True)
    assert (np.einsum("nk,nk->n", outwards, turns[:, :, 2]) > 0.99).all()  # facets of a ball
    np.testing.assert_allclose(
        places, np.array(grasps["suction_points"]) + 1e-3 * turns[:, :, 2], atol=1e-8
    )
    np.testing.assert_allclose(grasps["approach_vectors"], turns[:, :, 2], atol=1e-8)


@pytest.mark.parametrize("label", ["box", "ball"])
def test_a_cup_seals_where_its_ring_stays_on_a_face_and_on_a_ball(folder, label):
    written = read(folder, label)
    points = np.array(written["grasps"]["suction_points"])
    sealed = written["grasps"]["is_sealed"]
    assert written["object"] == {"file": f"{label}.obj", "scale": 1.0}
    if label == "box":  # the ring of 15 mm stays on a face
        face = np.isclose(np.abs(points), BOX.extents / 2, atol=1e-7)
        room = np.where(face, np.inf, BOX.extents / 2 - np.abs(points)).min(axis=1)
        assert np.all(np.array(sealed)[room > 0.0151])
        assert not np.any(np.array(sealed)[room < 0.0145])
    else:
        assert all(sealed)
    assert written["grasps"]["object_in_gripper"] == sealed  # nothing else is in the way
    scores = np.array(written["grasps"]["score"])
    assert scores.max() > 0.2
    np.testing.assert_allclose(25 * scores, np.round(25 * scores))


def test_every_object_is_listed_once_and_the_cup_is_described(folder):
    listed = [line for path in folder.glob("splits/*/*.txt") for line in path.read_text().split()]
    assert sorted(listed) == ["ball.obj", "box.obj"]
    assert trimesh.load(folder / "objects" / "box.obj").volume == pytest.approx(BOX.volume)
    (path,) = folder.glob("gripper/*.yaml")
    cup = yaml.safe_load(path.read_text())
    assert (cup["radius"], cup["height"], cup["num_sides"]) == (0.015, 0.03, 15)
    assert cup == {
        **read(folder, "box")["gripper"],
        "depth": 0.12,
        "control_points": [[0, 0, 0], [0, 0, 0.03], [0, 0, 0.12]],
    }
    shape = trimesh.load(path.with_suffix(".obj"))
    np.testing.assert_allclose(shape.bounds, [[-0.015, -0.015, 0], [0.015, 0.015, 0.12]], atol=1e-6)
    assert shape.is_watertight


def test_formats_are_for_jaws_or_for_cups(tmp_path):
    with pytest.raises(UserError, match="'graspgen' is not for cup_30mm, which has a suction cup"):
        egad.export({"box": BOX}, "graspgen", "cup_30mm", tmp_path / "a")
    with pytest.raises(UserError, match="'graspgen_suction' is not for panda, which has jaws"):
        egad.export({"box": BOX}, "graspgen_suction", "panda", tmp_path / "b")
    assert egad.export({"box": BOX}, "stl", "cup_30mm", tmp_path / "c").labels == ["box"]


def test_grasps_of_a_cup_are_read_as_they_were_sampled(tmp_path):
    sampled = egad.sample_grasps(BALL, "cup_30mm", n=30)
    hand = egad.gripper("cup_30mm")
    start_suction(tmp_path, "cup", hand.cup)
    write_suction(tmp_path, "cup", hand.cup, "ball", BALL, sampled.to_frame())
    path = tmp_path / "grasp_data/cup/ball.json"
    found = egad.read_grasps(path, mesh=BALL, gripper="cup_30mm")
    assert found.poses == pytest.approx(sampled.poses, abs=2e-9)
    assert found.contacts == pytest.approx(sampled.contacts, abs=2e-9)
    assert (found.widths == 0).all()
    assert (found.collision_free == sampled.collision_free).all()
    assert (found.source_score == sampled.quality).all()
    assert found.source_success.all()
    # the copies are perturbed by other random numbers: 25 of each grasp, and 30 grasps
    assert found.quality.mean() == pytest.approx(sampled.quality.mean(), abs=0.05)
    bare = egad.read_grasps(path)
    assert bare.poses == pytest.approx(sampled.poses, abs=2e-9)
    for refused in (egad.check_grasps, lambda *args: egad.try_grasps(found, *args[1:])):
        with pytest.raises(
            UserError, match="needs a gripper with two jaws; this one has a suction"
        ):
            refused(path, BALL, "cup_30mm")
    with pytest.warns(UserWarning, match="only 0% of the grasps have the object below the cup"):
        egad.read_grasps(path, mesh=BALL.copy().apply_translation((1, 0, 0)), gripper="cup_30mm")
    with pytest.raises(UserError, match="graspgen_suction is not for panda, which has jaws"):
        egad.read_grasps(path, gripper="panda")


def test_the_quality_of_a_cup_that_is_read_is_that_of_the_sampler(tmp_path):
    """The same random numbers are drawn for the same seed and number of a grasp."""
    table = sample_suction(BOX, egad.gripper("cup_30mm").cup, 12, seed=3)
    poses = suction_poses(table) @ np.diag([1.0, -1.0, -1.0, 1.0])
    poses[:, :3, 3] += 0.002 * poses[:, :3, 2]
    content = {"transforms": poses.tolist(), "suction_points": []}
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"gripper": {"standoff_distance": 0.002}, "grasps": content}))
    found = egad.read_grasps(path, mesh=BOX, gripper="cup_30mm", seed=3)
    assert found.poses == pytest.approx(suction_poses(table), abs=1e-12)
    assert found.quality == pytest.approx(table["quality"].to_numpy(), abs=0.041)  # a copy of 25
    assert (found.collision_free == table["collision_free"]).all()


@pytest.mark.parametrize(("hand", "points"), [("cup_30mm", {"suction_points": []}), ("panda", {})])
def test_a_gripper_that_is_text_is_told(tmp_path, hand, points):
    content = {"transforms": np.eye(4)[None].tolist(), **points}
    (tmp_path / "a.json").write_text(json.dumps({"gripper": hand, "grasps": content}))
    with pytest.raises(UserError, match="its gripper holds a str in place of names with values"):
        egad.read_grasps(tmp_path / "a.json", gripper=hand)


def test_a_label_of_another_program_is_kept(tmp_path, folder):
    (path,) = folder.glob("grasp_data/*/box.json")
    content = json.loads(path.read_text())
    labels = [number % 3 == 0 for number in range(30)]
    content["grasps"]["object_in_gripper"] = labels
    changed = tmp_path / "box.json"
    changed.write_text(json.dumps(content))
    read_again = egad.read_grasps(changed, mesh=BOX, gripper="cup_30mm")
    out = tmp_path / "out"
    export_grasps(read_again, BOX, "graspgen_suction", "cup_30mm", out, "box")
    assert read(out, "box")["grasps"]["object_in_gripper"] == labels
