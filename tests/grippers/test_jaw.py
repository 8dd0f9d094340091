"""Hands with one moving jaw, against the closed form of boxes with the sizes of an SO-101."""

import numpy as np
import pytest
import trimesh
from described_hands import FIXED_STEPS, HINGE, JAW_STROKE, PANDA, box_urdf, jaw_gap, jaw_urdf
from scipy.optimize import brentq

from egad.errors import UserError
from egad.grippers import Gripper, base_pose, joint_values, model_of
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER
from egad.grippers.reading import read_model

TIP = 82.0  # mm from the hinge


@pytest.fixture(scope="module", params=["boxes", "meshes"])
def model(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("hand") / "jaw.urdf"
    return read_model(jaw_urdf(path, meshes=request.param == "meshes"))


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return read_model(jaw_urdf(tmp_path_factory.mktemp("hand") / "jaw.urdf"))


def test_the_fixed_face_its_axes_and_the_pad_are_found(model):
    np.testing.assert_allclose(model.palm_to_hand[:3, :3], np.diag([1, -1, -1]), atol=1e-9)
    face = model.palm_to_hand[:3, 3] - [model.openings[0] / 2, 0, 0]
    np.testing.assert_allclose(face[:2], [-0.0079, 0], atol=1e-6)
    assert -0.1045 < face[2] < -0.095  # on the step at the tip
    assert [link.body for link in model.links] == [PALM_BODY, FIRST_FINGER, SECOND_FINGER]


def test_opening_and_angle_are_those_of_the_closed_form(model):
    z = model.palm_to_hand[2, 3]
    joint = model.positions[:, 0]
    gaps = [jaw_gap(angle, z) for angle in joint]
    np.testing.assert_allclose(model.openings, gaps, atol=1e-6)
    np.testing.assert_allclose(model.angles, joint, atol=1e-9)
    assert (np.diff(model.openings) > 0).all()


def test_gaps_along_the_jaws_are_those_of_the_closed_form(model):
    """At the depths where the line across meets the faces of both, not the side of a step."""
    depths = model.palm_to_hand[2, 3] - model.depths
    np.testing.assert_allclose(np.diff(model.depths), -0.01)
    expected = np.array([[jaw_gap(angle, z) for z in depths] for angle in model.positions[:, 0]])
    known = np.isfinite(expected)
    assert known.mean() > 0.85
    np.testing.assert_allclose(model.gaps[known], expected[known], atol=2e-6)
    np.testing.assert_allclose(model.gaps[:, 0], model.openings, atol=1e-6)


def test_it_opens_until_the_moving_tip_has_swung_past_the_pad(model):
    """About 60 mm, although the joint turns on to 100 degrees."""
    z = 1000 * model.palm_to_hand[2, 3]

    def beyond(angle):
        return HINGE[1] - TIP * np.cos(angle) - 12.3 * np.sin(angle) - z

    last = brentq(beyond, 0.3, 1.0)
    assert model.positions[-1, 0] == pytest.approx(last, abs=0.006)
    assert 0.056 < model.openings[-1] < 0.062


def test_links_are_where_the_joint_puts_them(model):
    """The palm stays where it is in the frame of the hand, and the fixed jaw with it."""
    assert np.ptp(model.places[:, :2], axis=0) == pytest.approx(0)
    hinge = np.array([HINGE[0], 0, HINGE[1]]) / 1000
    expected = model.palm_to_hand[:3, :3].T @ (hinge - model.palm_to_hand[:3, 3])
    np.testing.assert_allclose(model.places[:, 2], np.tile(expected, (65, 1)), atol=1e-9)
    for opening in (model.openings[0], 0.03, model.openings[-1]):
        middle = model.middle_at(np.array(opening))
        links = model.points(float(opening))
        fixed = np.concatenate(links[1]) - middle
        assert fixed[:, 0].max() == pytest.approx(-opening / 2, abs=1e-4)
        assert np.concatenate(links[0])[:, 2].max() < fixed[:, 2].min() + 1e-6


def test_convex_parts_leave_the_steps_of_the_jaws_free(model):
    """A point 1 mm before each step, but behind the one at the tip, is in no part."""
    origin, axes = model.palm_to_hand[:3, 3], model.palm_to_hand[:3, :3]
    for shapes in model.points(float(model.openings[-1]))[1:2]:
        for x, low, high, _ in FIXED_STEPS[1:-1]:
            point = np.array([x + 1, 0, (low + high) / 2]) / 1000
            assert not any(_within((point - origin) @ axes, corners) for corners in shapes)
            inner = point - [0.0025, 0, 0]
            assert any(_within((inner - origin) @ axes, corners) for corners in shapes)


def test_torque_is_force_times_the_depth_of_the_pads_below_the_hinge(model):
    assert model.lever == pytest.approx(HINGE[1] / 1000 - model.palm_to_hand[2, 3], abs=1e-9)


def test_a_servo_presses_less_where_the_pads_are_farther_from_the_hinge(tmp_path):
    """Moments about the hinge: the same torque at pads 10 mm nearer to it, at another tcp."""
    path, torque = jaw_urdf(tmp_path / "jaw.urdf"), 0.81
    tip = Gripper.from_file(path, torque=torque)
    lever = HINGE[1] / 1000 - model_of(tip).palm_to_hand[2, 3]
    assert tip.force == pytest.approx(torque / lever)
    deeper = Gripper.from_file(path, torque=torque, tcp=(-0.0099, 0, -0.09))
    assert deeper.force == pytest.approx(torque / (0.09 + HINGE[1] / 1000), rel=1e-4)
    assert Gripper(**deeper.model_dump()) == deeper


def test_a_torque_that_cannot_apply_is_refused(tmp_path):
    path = jaw_urdf(tmp_path / "jaw.urdf")
    slides = jaw_urdf(tmp_path / "slides.urdf", slides=True)
    with pytest.raises(UserError, match=r"gives .* N at the pads.*force is 50: leave out one"):
        Gripper.from_file(path, torque=0.8, force=50)
    for file in (slides, box_urdf(tmp_path / "hand.urdf")):
        with pytest.raises(UserError, match="one jaw that turns; give its force"):
            Gripper.from_file(file, torque=0.8)
    with pytest.raises(UserError, match="torque is for the file of a hand"):
        Gripper(opening=0.08, torque=0.8)


def test_a_joint_that_counts_the_other_way_is_the_same_hand(tmp_path, boxes):
    found = read_model(jaw_urdf(tmp_path / "jaw.urdf", mirrored=True))
    np.testing.assert_allclose(found.openings, boxes.openings, atol=1e-9)
    np.testing.assert_allclose(found.positions, -boxes.positions, atol=1e-9)
    np.testing.assert_allclose(found.places, boxes.places, atol=1e-9)


def test_a_jaw_that_slides_keeps_its_faces_parallel(tmp_path):
    found = read_model(jaw_urdf(tmp_path / "jaw.urdf", slides=True))
    np.testing.assert_allclose(found.angles, 0, atol=1e-9)
    np.testing.assert_allclose(found.openings, found.positions[:, 0], atol=2e-5)
    assert found.openings[-1] == pytest.approx(JAW_STROKE, abs=1e-6)
    assert found.lever == pytest.approx(1.0)
    np.testing.assert_allclose(found.aside, (found.openings - found.openings[0]) / 2)


def test_programs_that_set_the_joint_and_the_base_have_the_pads_at_the_contacts(tmp_path):
    gripper = Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"))
    model = model_of(gripper)
    for opening in (0.01, 0.025, 0.05):
        (angle,) = joint_values(gripper, opening).values()
        assert jaw_gap(angle, model.palm_to_hand[2, 3]) == pytest.approx(opening, abs=1e-5)
        pad = np.array([-0.0079, 0, model.palm_to_hand[2, 3], 1])
        np.testing.assert_allclose(
            (base_pose(gripper, opening) @ pad)[:3], [-opening / 2, 0, 0], atol=1e-6
        )


def test_a_sliding_finger_against_a_fixed_one_is_a_hand(tmp_path):
    """The boxes of a Panda, one of them fixed to the palm: half as wide, and one-sided."""
    fixed = {'name="left_joint" type="prismatic"': 'name="left_joint" type="fixed"'}
    found = read_model(box_urdf(tmp_path / "half.urdf", changes=fixed))
    assert found.openings[[0, -1]] == pytest.approx([2e-4, PANDA["opening"] / 2 + 2e-4], abs=1e-6)
    assert found.lever == pytest.approx(1.0)
    np.testing.assert_allclose(found.palm_to_hand[:3, :3], np.eye(3), atol=1e-9)
    np.testing.assert_allclose(found.palm_to_hand[:3, 3], [0, 0, PANDA["finger"][2] / 2], atol=3e-4)


def test_the_pads_of_a_koch_arm_are_found(tmp_path):
    """Boxes as MuJoCo Menagerie has them: jaws along -x, a hinge along -z, closed at 0.032 rad."""
    boxes = ((-0.0668, 0.0025), (-0.0628, 0.0052))
    fixed, moving = (
        "".join(
            f'<geom type="box" size="0.002 0.002 {half}" pos="{x + shift} {y} {z}"/>'
            for x, half in boxes
        )
        for shift, y, z in ((0.0, 0.0105, 0.0005), (0.0133, 0.0113, -0.01395))
    )
    path = tmp_path / "koch.xml"
    path.write_text(f"""<mujoco><compiler angle="radian"/><worldbody><body name="static">
      <geom type="box" size="0.02 0.015 0.015" pos="-0.02 0.005 0"/>{fixed}
      <body name="moving" pos="-0.01315 -0.0075 0.0145">
        <joint name="gripper" axis="0 0 -1" range="-1.6 0.032"/>{moving}
      </body></body></worldbody>
      <actuator><position joint="gripper"/></actuator></mujoco>""")
    found = read_model(path)
    axes = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]])  # closing, across, approach in columns
    np.testing.assert_allclose(found.palm_to_hand[:3, 0], [0, -1, 0], atol=1e-9)
    np.testing.assert_allclose(found.palm_to_hand[:3, :3], axes, atol=1e-9)
    x = found.palm_to_hand[0, 3] + 0.01315
    turned = found.positions[:, 0]
    along = (x - 0.0133 * np.sin(turned)) / np.cos(turned)  # on the moving face, from the hinge
    face = -0.0075 - along * np.sin(turned) + 0.0133 * np.cos(turned)
    np.testing.assert_allclose(found.openings, 0.0085 - face, atol=2e-6)
    np.testing.assert_allclose(found.angles, -turned, atol=1e-9)
    assert found.positions[0, 0] == pytest.approx(0.032)
    assert found.lever == pytest.approx(-x, abs=1e-6)


BAD = {
    "jaws beside each other": (
        {f'<origin xyz="{HINGE[0] / 1000} 0 ': f'<origin xyz="{HINGE[0] / 1000} 0.06 '},
        "its jaws never face each other: no face of the moving link jaw closes against",
    ),
    "degrees": (
        {f'lower="{-0.1745}" upper="{1.7453}"': 'lower="-10" upper="100"'},
        "the joint swing turns by 110 rad, more than once around; limits .* in radians",
    ),
    "cannot move": (
        {'lower="-0.1745"': 'lower="2"'},
        "the joint swing cannot move: its lower limit is above its upper one",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_jaw_that_cannot_be_used_is_named(tmp_path, case):
    changes, words = BAD[case]
    path = jaw_urdf(tmp_path / "bad.urdf", changes=changes)
    with pytest.raises(UserError, match=words) as refused:
        read_model(path)
    assert str(path) in str(refused.value)


def test_a_palm_without_shapes_is_no_jaw(tmp_path):
    path = jaw_urdf(tmp_path / "bad.urdf")
    head, tail = path.read_text().split('<link name="jaw">')
    path.write_text(head.replace("collision>", "visual>") + '<link name="jaw">' + tail)
    with pytest.raises(UserError, match="only the link jaw has collision shapes"):
        read_model(path)


def _within(point, corners):
    from scipy.spatial import ConvexHull  # noqa: PLC0415 (slow to load)

    planes = ConvexHull(corners).equations
    return bool((planes[:, :3] @ point + planes[:, 3] < 0).all())


def test_plates_that_toe_in_meet_at_their_tips_whatever_is_rough_behind(tmp_path):
    """Plates 45 mm long, parallel at 30 mm; the hinge is 65 mm behind them.

    Flanks of ridges are at 62 degrees where the plates are parallel, and at 78 where they meet.
    """
    plate = [(0.03, 0, 0), (0.034, 0, 0), (0.034, 0, 0.045), (0.03, 0, 0.045)]
    ridges = [
        [(0.0305, 0, z), (0.0292, 0, z), (0.0305, 0, z - 0.0007)]
        for z in np.arange(0.004, 0.022, 0.0011)
    ]
    for name, profiles in (("smooth", [plate]), ("rough", [plate, *ridges])):
        solids = [
            trimesh.convex.convex_hull([(x, y, z) for x, _, z in each for y in (-0.008, 0.008)])
            for each in profiles
        ]
        trimesh.util.concatenate(solids).export(tmp_path / f"{name}.stl")
        path = tmp_path / f"{name}.urdf"
        path.write_text(f"""<robot name="plates"><link name="fixed">
          <collision><origin xyz="-0.002 0 0.0225"/><geometry><box size="0.004 0.016 0.045"/>
          </geometry></collision></link><link name="jaw"><collision>
          <origin xyz="-0.03 0 0.065"/><geometry><mesh filename="{name}.stl"/></geometry>
          </collision></link><joint name="swing" type="revolute"><parent link="fixed"/>
          <child link="jaw"/><origin xyz="0.03 0 -0.065"/><axis xyz="0 1 0"/>
          <limit lower="-0.5" upper="1.5" effort="1" velocity="1"/></joint></robot>""")
        found = read_model(path)
        closed = np.arcsin(30 / 110)
        meet = -65 + 110 * np.cos(closed)
        middle = (meet - 2 / np.tan(closed) + 45) / 2  # what is within 2 mm there, and the tip
        z = 1000 * found.palm_to_hand[2, 3]
        assert z == pytest.approx(middle, abs=0.6)
        wide = 30 + 110 * np.sin(np.arccos((z + 65) / 110))
        assert 1000 * found.openings[[0, -1]] == pytest.approx([0, wide], abs=0.7)
