"""Joint values and base pose, against forward kinematics of the file by MuJoCo."""

import mujoco
import numpy as np
import pytest
from described_hands import PAD, box_urdf, linkage_mjcf

import egad
from egad.grippers import Gripper, base_link, base_pose, joint_values


def test_a_program_that_sets_the_joints_and_the_base_has_the_pads_at_the_contacts(tmp_path):
    """A linkage: its base moves back while the fingers open, and its pads stay where they are."""
    path = linkage_mjcf(tmp_path / "hand.xml")
    gripper = Gripper.from_file(path)
    description = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(description)
    pads = [description.geom(f"{side}_pad").id for side in ("left", "right")]
    for opening in np.linspace(0.001, gripper.opening, 7):
        (angle,) = joint_values(gripper, opening).values()
        for side in ("left", "right"):  # of a parallelogram: all bars lean alike
            for link in ("outer", "inner", "finger"):
                data.joint(f"{side}_{link}").qpos = angle
        mujoco.mj_kinematics(description, data)
        assert base_link(gripper) == "base"
        pose = base_pose(gripper, opening)
        places = (data.geom_xpos[pads] - data.body("base").xpos) @ pose[:3, :3].T + pose[:3, 3]
        side = (opening + PAD) / 2
        np.testing.assert_allclose(places, [[-side, 0, 0], [side, 0, 0]], atol=1e-5)


def test_joints_that_mimic_others_are_left_out(tmp_path):
    coupled = Gripper.from_file(box_urdf(tmp_path / "coupled.urdf"))
    assert joint_values(coupled, 0.0502) == pytest.approx({"left_joint": 0.025}, abs=1e-6)
    free = Gripper.from_file(box_urdf(tmp_path / "free.urdf", mimic=False))
    assert joint_values(free, 0.0502) == pytest.approx(
        {"left_joint": 0.025, "right_joint": 0.025}, abs=1e-6
    )


def test_an_opening_beyond_the_hand_is_its_widest(tmp_path):
    gripper = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    assert joint_values(gripper, 0.2) == pytest.approx({"left_joint": 0.04}, abs=1e-9)


def test_boxes_have_no_joints_and_no_links():
    panda = egad.gripper("panda")
    assert joint_values(panda, 0.04) == {}
    assert base_link(panda) is None
    assert base_pose(panda, 0.04) is None
