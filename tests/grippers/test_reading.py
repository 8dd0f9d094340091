"""Hands read from URDF and MJCF, against closed forms and MuJoCo's own simulation."""

import mujoco
import numpy as np
import pytest
from described_hands import BAR, INSET, PAD, PANDA, SWING, box_urdf, linkage_mjcf

from egad.errors import UserError
from egad.grippers.fingers import find_driven
from egad.grippers.reading import Choices, read_model

THICK, WIDE, LONG = PANDA["finger"]


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return read_model(box_urdf(tmp_path_factory.mktemp("hand") / "boxes.urdf"))


@pytest.fixture(scope="module")
def linkage_file(tmp_path_factory):
    return linkage_mjcf(tmp_path_factory.mktemp("hand") / "linkage.xml")


@pytest.fixture(scope="module")
def linkage(linkage_file):
    return read_model(linkage_file)


def test_boxes_on_sliding_joints_are_found(boxes):
    assert boxes.links[0].name == "hand"
    assert [(link.name, link.body) for link in boxes.links[1:]] == [("left", -1), ("right", 1)]
    assert boxes.joints == ("left_joint", "right_joint")
    assert boxes.openings[[0, -1]] == pytest.approx([2e-4, PANDA["opening"] + 2e-4], abs=1e-8)
    np.testing.assert_allclose(boxes.palm_to_hand[:3, :3], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(boxes.palm_to_hand[:3, 3], [0, 0, LONG / 2], atol=1e-8)
    np.testing.assert_allclose(np.ptp(boxes.pad, axis=0), [2e-4, WIDE, LONG], atol=1e-8)


def test_joints_and_openings_are_functions_of_each_other(linkage):
    for opening in np.linspace(linkage.openings[0], linkage.openings[-1], 23):
        positions = linkage.joint_positions(opening)
        assert linkage.opening_at(positions["left_outer"]) == pytest.approx(opening, abs=1e-6)
        assert positions["left_inner"] == pytest.approx(positions["right_outer"], abs=1e-6)
        assert positions["left_finger"] == pytest.approx(positions["left_outer"], abs=1e-6)


def test_the_fingers_of_a_parallelogram_move_on_arcs(linkage):
    """Its hinges are 2 * INSET apart, and each bar of length BAR leans inwards by the angle."""
    angle = linkage.positions[:, linkage.joints.index("left_outer")]
    np.testing.assert_allclose(linkage.openings, 2 * (INSET - BAR * np.sin(angle) - PAD), atol=1e-8)
    height = BAR * (np.cos(angle) - np.cos(angle[0]))
    np.testing.assert_allclose(linkage.reach, height, atol=1e-8)
    assert linkage.openings[0] == pytest.approx(0, abs=1e-8)
    fingers = [n for n, link in enumerate(linkage.links) if "finger" in link.name]
    np.testing.assert_allclose(np.ptp(linkage.turns[:, fingers], axis=0), 0, atol=1e-9)


def test_between_tabulated_openings_links_are_where_joints_put_them(linkage, linkage_file):
    """Against forward kinematics with the joints of the model."""
    description = mujoco.MjModel.from_xml_path(str(linkage_file))
    data = mujoco.MjData(description)
    for opening in np.random.default_rng(0).uniform(*linkage.openings[[0, -1]], 20):
        for name, position in linkage.joint_positions(opening).items():
            data.joint(name).qpos = position
        mujoco.mj_kinematics(description, data)
        _, places = linkage.poses(opening)
        for link, place in zip(linkage.links, places, strict=True):
            expected = linkage.palm_to_hand[:3, :3].T @ (
                data.body(link.name).xpos - data.body("base").xpos - linkage.palm_to_hand[:3, 3]
            )
            np.testing.assert_allclose(place, expected, atol=2e-6)


def test_the_path_of_the_fingertips_is_that_of_a_simulation(linkage, linkage_file):
    """The engine closes the hand by its motor, with its own soft constraints: within 0.5 mm."""
    description = mujoco.MjModel.from_xml_path(str(linkage_file))
    description.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    data = mujoco.MjData(description)
    pads = [description.geom(f"{side}_pad").id for side in ("left", "right")]
    seen = []
    for target in np.linspace(0.12, 0.74, 25):
        data.ctrl[0] = target
        mujoco.mj_step(description, data, 1500)
        left, right = data.geom_xpos[pads]
        seen.append((right[0] - left[0] - PAD, (left + right)[2] / 2))
    openings, heights = np.array(seen).T
    assert np.ptp(openings) > 0.06
    reach = linkage.reach_at(openings)
    difference = (heights - heights[-1]) - (reach - reach[-1])
    assert np.abs(difference).max() < 5e-4
    angle = linkage.positions[:, 0]
    inside = np.interp(np.linspace(0.12, 0.74, 25), angle[::-1], linkage.openings[::-1])
    assert np.abs(inside - openings).max() < 5e-4


def test_independent_fingers_close_together(tmp_path, boxes):
    """Two joints that no constraint couples are driven as one."""
    free = read_model(box_urdf(tmp_path / "free.urdf", mimic=False))
    np.testing.assert_allclose(free.openings, boxes.openings, atol=1e-9)
    np.testing.assert_allclose(free.places, boxes.places, atol=1e-9)


def test_an_arm_before_the_hand_stays_where_it_is(tmp_path, boxes):
    arm = """<robot name="arm"><link name="base"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="wrist"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <link name="wrist"/>
  <joint name="flange" type="fixed"><parent link="wrist"/><child link="hand"/>
    <origin rpy="0 0 1"/></joint>"""
    path = box_urdf(tmp_path / "arm.urdf", changes={'<robot name="boxes">': arm})
    found = read_model(path)
    assert [link.name for link in found.links] == ["hand", "left", "right", "wrist"]
    np.testing.assert_allclose(found.openings, boxes.openings, atol=1e-9)
    np.testing.assert_allclose(found.places[:, :3], boxes.places, atol=1e-9)


def test_choices_come_before_what_is_found(tmp_path):
    path = box_urdf(tmp_path / "boxes.urdf")
    found = read_model(
        path, Choices("right_joint", ("left", "right"), ("left", "right"), (0.0, 0.0, 0.03))
    )
    np.testing.assert_allclose(found.palm_to_hand[:3, 3], [0, 0, 0.03])
    turned = read_model(path, Choices(closing_axis=(-1.0, 0.0, 0.0), approach_axis=(0.0, 1.0, 0.0)))
    np.testing.assert_allclose(turned.palm_to_hand[:3, 0], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(turned.palm_to_hand[:3, 2], [0, 1, 0], atol=1e-12)
    assert [link.body for link in turned.links] == [0, 1, -1]


BAD = {
    "no joint": ({'type="prismatic"': 'type="fixed"'}, "none of its joints moves"),
    "one finger": (
        {
            'name="left_joint" type="prismatic"': 'name="left_joint" type="fixed"',
            f'"{-(THICK / 2 + 1e-4)} 0 ': f'"{-(THICK / 2 + 1e-4)} {2 * WIDE} ',
        },
        "its jaws never face each other: no face of the moving link right",
    ),
    "no opening": (
        {'upper="0.04"': 'upper="0.0001"'},
        "its links left and right are at most 0.4 mm apart",
    ),
    "limits in millimetres": (
        {'upper="0.04"': 'upper="40"'},
        "its links left and right open 80 m; limits of sliding joints are in metres",
    ),
    "beside each other": (
        {
            f'"{side * (THICK / 2 + 1e-4)} 0 ': f'"{side * (THICK / 2 + 1e-4)} {side * WIDE} '
            for side in (-1, 1)
        },
        "no face of the links left is opposite one of the links right",
    ),
    "missing mesh": (
        {f'<box size="{THICK} {WIDE} {LONG}"/>': '<mesh filename="package://maker/no.stl"/>'},
        "a mesh of the link left is missing: package://maker/no.stl",
    ),
    "millimetres": (
        {f'<box size="{THICK} {WIDE} {LONG}"/>': '<box size="10 21 44.5"/>'},
        "the link left is 44.5 m wide.*millimetres",
    ),
    "not XML": ({"<robot": "robot"}, "not URDF or MJCF"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_hand_that_cannot_be_used_is_refused_with_the_link_or_joint(tmp_path, case):
    changes, words = BAD[case]
    path = box_urdf(tmp_path / "bad.urdf", changes=changes)
    with pytest.raises(UserError, match=words) as refused:
        read_model(path)
    assert str(path) in str(refused.value)


def test_warnings_of_mujoco_are_logged_with_the_file(tmp_path, monkeypatch, caplog):
    """By itself, MuJoCo writes them into a file in the current folder."""
    monkeypatch.chdir(tmp_path)
    path = box_urdf(tmp_path / "boxes.urdf", changes=BAD["one finger"][0])
    with pytest.raises(UserError):
        read_model(path)
    assert list(tmp_path.iterdir()) == [path]
    assert any(str(path) in text and "<mimic>" in text for text in caplog.messages)


def test_a_hand_without_collision_shapes_is_refused(tmp_path):
    path = box_urdf(tmp_path / "bare.urdf", changes={"collision>": "visual>"})
    with pytest.raises(UserError, match=r"none of its links has .* shapes: hand, left, right"):
        read_model(path)


def test_fingers_without_collision_shapes_are_named(tmp_path):
    """The palm has one, so that the file is not refused as a whole."""
    path = box_urdf(tmp_path / "bare.urdf")
    head, *sides = path.read_text().split('<link name="left">')
    path.write_text(head + '<link name="left">' + sides[0].replace("collision>", "visual>"))
    with pytest.raises(UserError, match="its moving links have no collision shapes: left, right"):
        read_model(path)


def test_a_joint_whose_limits_are_reversed_is_named(tmp_path):
    words = "the joint {} cannot move: its lower limit is above its upper one"
    limits = {'lower="0" upper="0.04"': 'lower="0.04" upper="0"'}
    with pytest.raises(UserError, match=words.format("left_joint")):
        read_model(box_urdf(tmp_path / "reversed.urdf", changes=limits))
    with pytest.raises(UserError, match=words.format("left_outer")):
        read_model(linkage_mjcf(tmp_path / "reversed.xml", SWING[::-1]))


def test_joints_that_mimic_each_other_are_named(tmp_path):
    leads = '<child link="left"/><mimic joint="right_joint"/>'
    path = box_urdf(tmp_path / "round.urdf", changes={'<child link="left"/>': leads})
    with pytest.raises(UserError, match="each of its joints mimics another one: left_joint, right"):
        read_model(path)


def test_a_cable_does_not_drive_joints_with_the_numbers_of_its_sites():
    """Without other motors, the joint that mimics no other is driven."""
    sides = "".join(
        f"""<body name="{name}"><joint name="{name}" type="slide" axis="{way} 0 0" range="0 1"/>
        <geom type="box" size="0.01 0.01 0.04"/><site name="{name}"/></body>"""
        for name, way in (("left", -1), ("right", 1))
    )
    description = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>{sides}</worldbody>
    <equality><joint joint1="right" joint2="left"/></equality>
    <tendon><spatial name="cable"><site site="left"/><site site="right"/></spatial></tendon>
    <actuator><motor tendon="cable"/></actuator></mujoco>""")
    assert find_driven(description, [0, 1]) == [0]


def test_three_fingers_are_refused(tmp_path):
    third = """<link name="third"><collision><origin xyz="0 -0.02 0.02"/>
    <geometry><box size="0.01 0.01 0.04"/></geometry></collision></link>
  <joint name="third_joint" type="prismatic"><parent link="hand"/><child link="third"/>
    <axis xyz="0 -1 0"/><limit lower="0" upper="0.04" effort="1" velocity="1"/>
    <mimic joint="left_joint"/></joint></robot>"""
    path = box_urdf(tmp_path / "three.urdf", changes={"</robot>": third})
    with pytest.raises(UserError, match="left, right, third do not move as two fingers"):
        read_model(path)


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        (Choices(joint="no"), "joint is 'no'; the hand has left_joint, right_joint"),
        (Choices(finger_links=("left", "no")), "no link 'no'; it has hand, left, right"),
        (Choices(pad_links=("left", "no")), "no link 'no'"),
        (Choices(pad_links=("left", "left")), r"links left is opposite one of the links \(none\)"),
        (Choices(approach_axis=(1.0, 0.0, 0.0)), "approach is along its closing axis"),
        (Choices(closing_axis=(0.0, 0.0, 0.0)), r"closing_axis \[0.0, 0.0, 0.0\] has no direction"),
    ],
)
def test_wrong_choices_are_named(tmp_path, choices, words):
    with pytest.raises(UserError, match=words):
        read_model(box_urdf(tmp_path / "boxes.urdf"), choices)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(UserError, match=r"none\.urdf: there is no such file"):
        read_model(tmp_path / "none.urdf")
