"""The pages about a described hand and about a cup, and what is printed of them."""

import base64
import zlib
from dataclasses import replace

import numpy as np
import pytest
import trimesh
import yaml
from described_hands import PANDA, box_urdf, jaw_urdf, linkage_mjcf
from typer.testing import CliRunner

import egad
from egad.cli.commands import app
from egad.grasps.suction import limits, resists
from egad.grippers import Gripper, model_of
from egad.report.hand import (
    cup_entry,
    cup_facts,
    cup_page,
    hand_doubts,
    hand_entry,
    hand_facts,
    hand_page,
    hand_scene,
    jaw_table,
    spring_shapes,
)
from egad.report.viewer import viewer_data


def turned(axis, degrees):
    return trimesh.transformations.rotation_matrix(np.radians(degrees), axis)


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    file = box_urdf(tmp_path_factory.mktemp("hand") / "boxes.urdf")
    return Gripper.from_file(file, joint="left_joint", force=70)


def test_the_entry_gives_the_same_gripper(boxes):
    ((name, entry),) = yaml.safe_load(hand_entry("mine", boxes, model_of(boxes)))[
        "grippers"
    ].items()
    assert name == "mine"
    assert sorted(entry) == ["file", "force", "joint"]
    assert Gripper(**entry) == boxes
    bare = boxes.model_copy(update={"pads": "bare"})
    assert (
        Gripper(**yaml.safe_load(hand_entry("mine", bare, model_of(bare)))["grippers"]["mine"])
        == bare
    )


def test_facts_are_in_millimetres(boxes, tmp_path):
    facts = hand_facts(boxes, model_of(boxes))
    assert facts["opening"] == "0.2 to 80.2 mm"
    assert facts["fingers"] == "left; right"
    assert facts["closing axis"] == "1, 0, 0"
    assert facts["travel of the pads along the approach"] == "none"
    linkage = Gripper.from_file(linkage_mjcf(tmp_path / "linkage.xml"))
    assert (
        hand_facts(linkage, model_of(linkage))["travel of the pads along the approach"] == "15.9 mm"
    )


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ('lower="0.01" upper="0.02"', "The closed pads are still 20.2 mm apart"),
        ('lower="0" upper="0.002"', "The hand opens only 4.2 mm: check its limits."),
    ],
)
def test_a_doubtful_reading_is_said_and_not_ready_to_paste(tmp_path, limits, words):
    file = box_urdf(tmp_path / "odd.urdf", changes={'lower="0" upper="0.04"': limits})
    hand = Gripper.from_file(file)
    (doubt,) = hand_doubts(hand, model_of(hand))
    assert doubt.startswith(words)
    assert hand_facts(hand, model_of(hand))["doubtful (1)"] == doubt
    assert yaml.safe_load(hand_entry("odd", hand, model_of(hand))) is None
    assert "# grippers:" in hand_page("odd", hand, model_of(hand))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pad": np.array([[0, -0.0009, 0], [0, 0.0009, 0.02]])}, "The pads measure only 1.8 mm"),
        ({"recess": (0.6, 0.006)}, "Most of the faces of the pads lie far behind"),
        ({"palm_to_hand": turned((0, 1, 0), 3)}, "The closing axis is 3 degrees off"),
        ({"palm_to_hand": turned((1, 0, 0), 3)}, "The approach is 3 degrees off"),
    ],
)
def test_odd_pads_and_tilted_axes_are_doubtful(boxes, changes, words):
    model = replace(model_of(boxes), **changes)
    doubts = hand_doubts(boxes, model)
    assert any(doubt.startswith(words) for doubt in doubts)
    chosen = {"closing_axis": (1.0, 0, 0), "approach_axis": (0.0, 0, 1)}
    rest = hand_doubts(boxes.model_copy(update=chosen), model)
    assert not any("off the axes" in doubt for doubt in rest)


def test_pads_that_are_not_flat_are_said_to_be_measured_between_their_foremost_points(tmp_path):
    """A step of 3 mm on half of each finger: 6 mm more between what lies behind."""
    thick, wide, long = PANDA["finger"]
    old = f'<geometry><box size="{thick} {wide} {long}"/></geometry>\n  </collision>'
    step = f"""<geometry><box size="{thick - 0.006} {wide} {long}"/></geometry></collision>
      <collision><origin xyz="{{}} 0 {long / 4}"/>
      <geometry><box size="{thick} {wide} {long / 4}"/></geometry></collision><collision>
      <origin xyz="{{}} 0 {3 * long / 4 + long / 8}"/>
      <geometry><box size="{thick} {wide} {long / 4}"/></geometry></collision>"""
    path = box_urdf(tmp_path / "steps.urdf")
    first, left, right = path.read_text().split(old)
    ends = (-(thick / 2 + 1e-4), thick / 2 + 1e-4)
    text = first + step.format(ends[0], ends[0]) + left + step.format(ends[1], ends[1]) + right
    path.write_text(text)
    hand = Gripper.from_file(path)
    said = hand_facts(hand, model_of(hand))["opening"]
    assert said.startswith("0.2 to 80.2 mm between the foremost points of the pads; ")
    assert said.endswith(" % of their faces lie further back, the rearmost 6.0 mm farther apart")


def test_a_hand_with_one_moving_jaw_has_a_table_of_its_joint(tmp_path, boxes):
    hand = Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10)
    model = model_of(hand)
    facts, rows = hand_facts(hand, model), jaw_table(model)
    assert facts["fingers"] == "gripper-fixed-jaw; jaw"
    assert "parallel at 15.8 mm" in facts["angle between the jaws"]
    assert facts["strength of the joint"].startswith(f"{10 * model.lever:.3g} N m for 10 N")
    assert rows[0]["joint"] == rows[0]["angle"] == "-10.0 deg"
    # a round body between faces at 30 degrees is held with friction of tan(15 degrees)
    assert float(rows[-1]["friction"]) == pytest.approx(np.tan(model.angles[-1] / 2), abs=0.005)
    page = hand_page("jaw", hand, model)
    assert all(cell in page for row in rows for cell in row.values())
    slides = Gripper.from_file(jaw_urdf(tmp_path / "slides.urdf", slides=True), force=10)
    found = hand_facts(slides, model_of(slides))
    assert found["angle between the jaws"] == "none"
    assert found["strength of the joint"] == "10 N for 10 N at the pads"
    assert "moving jaw" not in hand_facts(boxes, model_of(boxes))
    assert jaw_table(model_of(boxes)) == []


def test_colors_of_faces_are_packed_last(boxes):
    scene = hand_scene(model_of(boxes), "open", 0.08)
    (packed,) = viewer_data([scene], boxes)["objects"]
    data = zlib.decompress(base64.b64decode(packed["data"]))
    colors = np.frombuffer(data[-len(scene.mesh.faces) :], np.uint8)
    # palm, two fingers, two pads: 12 triangles each; and the bar
    assert np.bincount(colors).tolist()[:4] == [12, 12, 12, 24]
    palm = scene.mesh.vertices[scene.mesh.faces[colors == 0]].reshape(-1, 3)
    assert np.ptp(palm, axis=0) == pytest.approx(PANDA["palm"])


CUP = egad.SuctionCup(radius=0.01, height=0.025, sides=12, vacuum_force=20, friction=0.4)


@pytest.mark.parametrize(
    ("part", "place"),
    [("pull", 2), ("across", 0), ("across", 1), ("torsion", 5), ("bending", 3), ("bending", 4)],
)
def test_a_limit_is_where_the_cup_lets_go(part, place):
    load = np.zeros((2, 6))
    load[:, place] = getattr(limits(CUP), part) * np.array([0.999, 1.001])
    assert resists(CUP, load).tolist() == [True, False]


def test_the_springs_are_drawn_with_their_lengths():
    assert len(spring_shapes(CUP)) == 3 * CUP.sides
    expected = {1: 2 * 0.01 * np.sin(np.pi / 12), 2: 0.01, 3: np.hypot(0.01, 0.025)}  # by color
    for shape, color in spring_shapes(CUP):
        span = np.linalg.norm(shape.vertices[:, None] - shape.vertices[None], axis=2).max()
        assert span == pytest.approx(expected[color], rel=0.02)


def test_facts_and_page_name_the_cup():
    facts = cup_facts(CUP)
    assert facts["pull along the axis"] == "20 N (2.04 kg)"
    assert facts["force across the axis"].startswith("4.62 N")  # 0.4 * 20 / sqrt(3)
    page = cup_page("mine", egad.Gripper(cup=CUP), CUP)
    assert "sampler: mine.py:f" in cup_entry("mine", egad.Gripper(cup=CUP, sampler="mine.py:f"))
    assert "The suction cup mine" in page
    assert "default-src 'none'" in page


def test_inspect_shows_a_cup_of_the_configuration(tmp_path):
    done = CliRunner().invoke(
        app, ["gripper", "inspect", "cup_15mm", "--out", str(tmp_path / "cup.html")]
    )
    assert done.exit_code == 0, done.output
    assert "15 mm across" in done.output
    assert "cup_15mm:" in done.output
    assert (tmp_path / "cup.html").is_file()
