"""URDF files with what MuJoCo refuses and a hand does not need, against the hand without it."""

import re

import numpy as np
import pytest
from described_hands import PANDA, box_urdf

from egad.errors import UserError
from egad.grippers.reading import Choices, read_model

LEFT, RIGHT = (
    '<parent link="hand"/><child link="left"/>',
    '<parent link="hand"/><child link="right"/>',
)
LIMIT = f'<limit lower="0" upper="{PANDA["opening"] / 2}" effort="10" velocity="1"/>'
IMPOSSIBLE = '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>'


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return read_model(box_urdf(tmp_path_factory.mktemp("hand") / "boxes.urdf"))


def inertial(text: str) -> dict[str, str]:
    """Changes that give the left finger an element `inertial`."""
    return {'<link name="left">': f'<link name="left"><inertial>{text}</inertial>'}


def whole(text: str) -> dict[str, str]:
    """Changes that add elements to the robot."""
    return {"</robot>": f"{text}</robot>"}


HARMLESS = {
    "inertia that does not add up": inertial(f'<mass value="0.1"/>{IMPOSSIBLE}'),
    "no effort": {' effort="10" velocity="1"': ""},
    "a second limit": {LIMIT: f'{LIMIT}<limit effort="100" velocity="100"/>'},
    "two origins and axes": {LIMIT: f'<origin/><origin xyz="1 0 0"/>{LIMIT}<axis xyz="0 0 1"/>'},
    "drives": whole(2 * '<transmission name="t"><joint name="left_joint"/></transmission>'),
    "a link twice": whole('<link name="tip"/>' * 2),
    "a joint twice": whole(
        '<link name="tip"/>'
        + 2 * '<joint name="tip" type="fixed"><parent link="left"/><child link="tip"/></joint>'
    ),
    "names of shapes twice": {"<collision>": '<collision name="shape">'},
    "an empty shape": {'<link name="left">': '<link name="left"><collision/>'},
    "a picture that is missing": {
        '<link name="left">': '<link name="left"><visual><geometry><mesh filename="no.dae"/>'
        "</geometry></visual>"
    },
    "a default name space": {"<robot ": '<robot xmlns="http://drake.mit.edu" '},
    "a free base": {
        '<link name="hand">': '<link name="world"/><joint name="free" type="floating">'
        '<parent link="world"/><child link="hand"/></joint><link name="hand">'
    },
}


@pytest.mark.parametrize("case", HARMLESS)
def test_what_a_hand_does_not_need_changes_nothing(tmp_path, boxes, case):
    found = read_model(box_urdf(tmp_path / "hand.urdf", changes=HARMLESS[case]))
    np.testing.assert_array_equal(found.openings, boxes.openings)
    names = [link.name for link in boxes.links]
    assert [link.name for link in found.links if link.name in names] == names
    for link in found.links:
        expected = [each for each in boxes.links if each.name == link.name]
        shapes = expected[0].shapes if expected else ()
        assert len(link.shapes) == len(shapes)
        for points, corners in zip(link.shapes, shapes, strict=True):
            np.testing.assert_array_equal(points, corners)
        given = "inertial" in str(HARMLESS[case]) and link.name == "left"
        if expected:
            assert link.mass == pytest.approx(0.1 if given else expected[0].mass)


def test_a_finger_that_moves_half_as_far_closes_from_60_mm(tmp_path):
    """One finger moves 40 mm, the other one 20."""
    half = {'<mimic joint="left_joint"/>': '<mimic joint="left_joint" multiplier="0.5"/>'}
    found = read_model(box_urdf(tmp_path / "half.urdf", changes=half))
    assert found.openings[[0, -1]] == pytest.approx([2e-4, 0.06 + 2e-4], abs=1e-8)


def test_of_repeated_limits_the_first_one_counts_and_is_logged(tmp_path, caplog):
    second = f'<limit lower="0" upper="0.01"/>{LIMIT}'
    path = box_urdf(tmp_path / "hand.urdf", changes={LIMIT: second})
    found = read_model(path)
    assert np.ptp(found.openings) == pytest.approx(0.02, abs=1e-8)
    assert f"{path}: the joint left_joint has 2 <limit> elements; only the first is used" in (
        caplog.messages
    )


BAD = {
    "macro": (whole('<xacro:property name="w" value="1"/>'), "xacro hand.urdf > expanded"),
    "expression": ({'size="': 'size="${w} '}, "xacro"),
    "other format": ({"<robot": "<sdf", "</robot": "</sdf"}, "root element is <sdf>"),
    "two links of a name": (
        {'<link name="right">': '<link name="left">'},
        "two different links named left",
    ),
    "kind of joint": (
        {"prismatic": "slider"},
        "the joint left_joint has the type 'slider'; allowed: fixed, revolute",
    ),
    "no name": ({'<link name="left">': "<link>"}, "one of its <link> elements has no name"),
    "two carriers": (
        {RIGHT: '<parent link="hand"/><child link="left"/>'},
        "the link left is the child of two joints, left_joint and right_joint",
    ),
    "missing link": (
        {LEFT: '<parent link="palm"/><child link="left"/>'},
        "the parent of the joint left_joint is 'palm', a link that is not in the file",
    ),
    "mass": (inertial('<mass value="nan"/>'), "the link left has value='nan' in <mass>"),
    "decimal comma": (
        {'upper="0.04"': 'upper="0,04"'},
        "the joint left_joint has upper='0,04' in <limit>; allowed: numbers like 0.04",
    ),
    "no end": ({'upper="0.04"': 'upper="inf"'}, "the joint left_joint has no limits, or equal"),
    "shape": (
        {"<box": "<cone", "geometry><cone": "geometry><cone"},
        "shape of the link hand is a <cone>; allowed: box, cylinder, sphere, capsule, mesh",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_read_is_refused_with_its_name(tmp_path, case):
    changes, words = BAD[case]
    path = box_urdf(tmp_path / "hand.urdf", changes=changes)
    with pytest.raises(UserError, match=words) as refused:
        read_model(path)
    assert str(path) in str(refused.value)


@pytest.mark.parametrize("name", ["hand.urdf", "hand.urdf.xacro", "hand.xacro", "a.xacro.urdf"])
def test_the_advice_for_xacro_never_writes_over_the_file(tmp_path, name):
    path = box_urdf(tmp_path / name, changes={'size="': 'size="${w} '})
    with pytest.raises(UserError) as refused:
        read_model(path)
    outputs = re.findall(r"(?:>|-o) ([^`]+)`", str(refused.value))
    assert len(outputs) == 2
    assert all(output.endswith(".urdf") and output != name for output in outputs)


ARM = """<robot name="arm"><link name="base"><collision>
    <geometry>{shape}</geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="hand"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint>"""


@pytest.mark.parametrize("shape", ['<mesh filename="no.stl"/>', '<box size="9 9 9"/>'])
def test_shapes_of_an_arm_are_not_needed(tmp_path, boxes, shape):
    """They may be missing, or larger than a hand."""
    changes = {'<robot name="boxes">': ARM.format(shape=shape)}
    found = read_model(box_urdf(tmp_path / "arm.urdf", changes=changes))
    assert [link.name for link in found.links] == ["hand", "left", "right"]
    np.testing.assert_allclose(found.openings, boxes.openings, atol=1e-12)


def test_of_a_whole_robot_the_fingers_are_named(tmp_path, boxes):
    """Its head also turns, and without limits."""
    head = """<link name="head"/><joint name="head" type="continuous">
    <parent link="base"/><child link="head"/></joint></robot>"""
    changes = {'<robot name="boxes">': ARM.format(shape='<box size="9 9 9"/>'), "</robot>": head}
    path = box_urdf(tmp_path / "robot.urdf", changes=changes)
    with pytest.raises(UserError, match=r"the joint head has no limits.*finger_links: \[NAME"):
        read_model(path)
    found = read_model(path, Choices(finger_links=("left", "right")))
    np.testing.assert_allclose(found.openings, boxes.openings, atol=1e-12)
