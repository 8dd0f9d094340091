"""The files are read the way that Isaac Sim's importer reads them, by a reader of our own."""

import mujoco
import numpy as np
import pytest
import trimesh
import yaml
from described_hands import PANDA, box_urdf, jaw_gap, jaw_urdf, linkage_mjcf
from scipy.spatial.transform import Rotation
from trimesh.transformations import translation_matrix

import egad
from egad import Gripper
from egad.exchange.grasps.isaac_grasp import write_isaac_grasp

LABEL = "A00_0"


@pytest.fixture(scope="module")
def rows(labelled):
    """Grasps at which the pads are the first to touch."""
    of_one = labelled[labelled["label"] == LABEL]
    known = of_one[of_one["simulated_success"].notna() | ~of_one["collision_free"]]
    return known.assign(needed_opening=known["width"])


def read(path):
    """The grasps of a file: confidence, pose (4, 4), joints, joints before; and all of it."""
    content = yaml.safe_load(path.read_text())
    assert (content["format"], content["format_version"]) == ("isaac_grasp", 1.0)
    found = []
    for grasp in content["grasps"].values():
        pose = np.eye(4)
        turn = [*grasp["orientation"]["xyz"], grasp["orientation"]["w"]]
        assert np.linalg.norm(turn) == pytest.approx(1)
        pose[:3, :3] = Rotation.from_quat(turn).as_matrix()
        pose[:3, 3] = grasp["position"]
        assert 0 <= grasp["confidence"] <= 1
        joints = grasp["cspace_position"], grasp["pregrasp_cspace_position"]
        found.append((grasp["confidence"], pose, *joints))
    return found, content


def contacts_of(rows, number):
    return rows[[f"contact{number}_{part}" for part in "xyz"]].to_numpy()


def test_pads_of_sliding_fingers_meet_the_contacts(rows, tmp_path):
    gripper = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, gripper, rows)
    found, content = read(tmp_path / "a.yaml")
    assert len(found) == len(rows) > 5
    assert content["object_frame"] == content["object_frame_link"] == LABEL
    assert content["gripper_frame"] == content["gripper_frame_link"] == "hand"
    for number, side in ((0, -1), (1, 1)):
        pairs = zip(found, contacts_of(rows, number), strict=True)
        for (_, pose, joints, before), contact in pairs:
            x, y, z = (np.linalg.inv(pose) @ [*contact, 1])[:3]
            assert list(joints) == list(before) == ["left_joint"]  # the other one mimics it
            # the inner faces of the fingers lie 0.1 mm behind the positions of their joints
            assert x == pytest.approx(side * (joints["left_joint"] + 1e-4), abs=1e-7)
            assert y == pytest.approx(0, abs=1e-7)
            assert z == pytest.approx(0.0445 / 2, abs=1e-7)
            assert before["left_joint"] == pytest.approx(0.04)


def test_pads_of_a_linkage_meet_the_contacts(rows, tmp_path):
    """MuJoCo places the links; contacts lie as far from both fingers as the pads do."""
    path = linkage_mjcf(tmp_path / "hand.xml")
    gripper = Gripper.from_file(path)
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, gripper, rows)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    found, content = read(tmp_path / "a.yaml")
    heights = []
    for (_, pose, joints, _), *contacts in zip(
        found, contacts_of(rows, 0), contacts_of(rows, 1), strict=True
    ):
        (data.qpos[:],) = joints.values()  # bars of equal length turn by the same angle
        mujoco.mj_kinematics(model, data)
        palm = data.body(content["gripper_frame"])
        fingers = [
            palm.xmat.reshape(3, 3).T @ (data.geom(number).xpos - palm.xpos)
            for number in ("left_pad", "right_pad")
        ]
        seen = [(np.linalg.inv(pose) @ [*contact, 1])[:3] for contact in contacts]
        middle = (fingers[0] + fingers[1]) / 2
        assert (seen[0] + seen[1]) / 2 == pytest.approx(middle, abs=2e-5)
        heights.append(middle[2])
    assert np.ptp(heights) > 1e-4  # they do move forward


def test_jaws_of_which_one_is_fixed_stand_beside_the_contacts(rows, tmp_path):
    """In the frame of the palm the fixed face is at -7.9 mm; the gap is that of the closed form."""
    beside = np.array([0.001, 0, 0])
    gripper = Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"))
    narrow = rows[rows["width"].between(0.003, gripper.opening)]
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, gripper, narrow)
    found, content = read(tmp_path / "a.yaml")
    assert content["gripper_frame"] == "gripper"
    contacts = zip(contacts_of(narrow, 0), contacts_of(narrow, 1), strict=True)
    for (_, pose, joints, _), pair in zip(found, contacts, strict=True):
        first, second = ((np.linalg.inv(pose) @ [*contact, 1])[:3] for contact in pair)
        assert first[:2] == pytest.approx([-0.0079 + 0.001, 0], abs=1e-6)
        gap = jaw_gap(joints["swing"], first[2])
        assert second - first + 2 * beside == pytest.approx([gap, 0, 0], abs=5e-5)
    assert len(found) > 5


def test_fingers_stop_at_what_they_touch_before_the_contacts(tmp_path):
    """A finger of the hand is wider than the waist that it grips, and stops at the plates."""
    plates = [trimesh.creation.box((0.05, 0.05, 0.01)) for _ in range(2)]
    for plate, height in zip(plates, (-0.01, 0.01), strict=True):
        plate.apply_translation((0, 0, height))
    waist = trimesh.creation.cylinder(0.01, 0.03)
    solid = trimesh.boolean.union([*plates, waist], engine="manifold")
    hand = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    frame = egad.sample_grasps(solid, hand, n=60).to_frame()
    free = frame[frame["collision_free"]].assign(simulated_outcome="success")
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, hand, free.assign(simulated_success=True))
    early = free["needed_opening"] > free["width"] + 0.005
    assert early.sum() > 5
    thick, wide, long = PANDA["finger"]
    inset = 1e-4
    for _, pose, joints, _ in read(tmp_path / "a.yaml")[0]:
        for side in (-1, 1):
            middle = side * (joints["left_joint"] + 1e-4 + thick / 2)
            place = pose @ translation_matrix((middle, 0, long / 2))
            finger = trimesh.creation.box(np.array((thick, wide, long)) - 2 * inset, place)
            assert trimesh.boolean.intersection([finger, solid], engine="manifold").is_empty


def test_only_grasps_that_held_have_confidence(rows, tmp_path):
    gripper = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, gripper, rows)
    held = rows["simulated_outcome"].isin(["success", "slipped_lifting", "dropped"])
    assert [each[0] for each in read(tmp_path / "a.yaml")[0]] == held.astype(float).tolist()


def test_an_object_of_which_nothing_is_known_has_no_grasps(rows, tmp_path):
    gripper = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    unknown = rows.assign(simulated_success=None, collision_free=True)
    write_isaac_grasp(tmp_path / "a.yaml", LABEL, gripper, unknown)
    assert read(tmp_path / "a.yaml")[0] == []
