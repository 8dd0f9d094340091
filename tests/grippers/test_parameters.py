"""Grippers from files: their sizes, and how they travel through configurations."""

import json
import os

import numpy as np
import pytest
from described_hands import BAR, PAD, PANDA, box_urdf, linkage_mjcf

import egad
from egad.errors import UserError
from egad.grippers import Gripper, body_of, model_of
from egad_workflow.check import check
from egad_workflow.settings import Settings

THICK, WIDE, LONG = PANDA["finger"]


@pytest.fixture(scope="module")
def boxes_file(tmp_path_factory):
    return box_urdf(tmp_path_factory.mktemp("hand") / "boxes.urdf")


def test_the_boxes_of_a_file_are_its_sizes(boxes_file):
    found = egad.Gripper.from_file(boxes_file, tcp=(0, 0, LONG - WIDE / 2), force=70)
    assert found.opening == pytest.approx(PANDA["opening"] + 2e-4)
    assert found.finger_length == pytest.approx(LONG)
    assert found.finger_width == pytest.approx(WIDE)
    assert found.finger_thickness == pytest.approx(THICK, abs=2e-4)
    assert found.fingertip == pytest.approx(WIDE / 2)
    assert found.palm == pytest.approx(PANDA["palm"])
    assert found.force == 70


def test_a_linkage_is_no_thicker_than_its_pad_is(tmp_path):
    found = Gripper.from_file(linkage_mjcf(tmp_path / "linkage.xml"))
    assert found.finger_thickness == pytest.approx(PAD, abs=1e-5)
    assert found.fingertip == pytest.approx(0.02, abs=1e-5)
    assert found.finger_length > BAR * 0.6


def test_fingers_are_as_long_as_they_are_when_the_hand_is_open(tmp_path):
    """Bars that lean outwards when open: then the pads are higher, and nearer to the palm."""
    outwards = Gripper.from_file(linkage_mjcf(tmp_path / "hand.xml", (-0.7, 0.0)))
    model = model_of(outwards)
    closed = model.positions[0, 0]
    assert model.reach[-1] == pytest.approx(BAR * (np.cos(0.7) - np.cos(closed)), abs=1e-6)
    lowest = max(points[:, 2].max() for points in model.points(model.openings[-1])[0])
    tips = max(
        points[:, 2].max()
        for link, shapes in zip(model.links, model.points(model.openings[-1]), strict=True)
        for points in shapes
        if link.body
    )
    assert outwards.finger_length == pytest.approx(tips - lowest, abs=1e-5)


def test_what_is_given_is_not_replaced(boxes_file):
    found = Gripper.from_file(boxes_file, opening=0.05, finger_width=0.03)
    assert (found.opening, found.finger_width) == (0.05, 0.03)
    first, *_ = body_of(found).parts()[1:]
    assert first.box[1, 0] == pytest.approx(-0.025, abs=1e-6)


def test_a_file_that_changes_is_read_again(tmp_path):
    path = box_urdf(tmp_path / "boxes.urdf")
    before = Gripper.from_file(path)
    box_urdf(path, changes={'upper="0.04"': 'upper="0.03"'})
    os.utime(path, ns=(0, 0))
    assert Gripper.from_file(path).opening == pytest.approx(before.opening - 0.02)


def test_a_file_and_a_mesh_exclude_each_other(boxes_file):
    with pytest.raises(UserError, match="not both"):
        Gripper.from_file(boxes_file, mesh="palm.stl")


def test_an_opening_beyond_that_of_the_file_is_refused(boxes_file):
    with pytest.raises(UserError, match=r"opening is 0\.2; the hand of .* opens at most 0\.0802 m"):
        Gripper.from_file(boxes_file, opening=0.2)


def test_resolved_settings_need_the_file_no_more(tmp_path):
    """As the JSON that jobs get; so a job that uses boxes alone reads nothing."""
    path = box_urdf(tmp_path / "boxes.urdf")
    found = Gripper.from_file(path)
    path.unlink()
    assert Gripper.model_validate_json(found.model_dump_json(), strict=True) == found


def test_a_configuration_names_the_file(boxes_file):
    grippers = Settings().model_dump(mode="json")["grippers"]
    grippers["mine"] = {"file": str(boxes_file), "tcp": [0, 0, 0.03]}
    mine = check({"grippers": grippers}).grippers["mine"]
    assert mine == Gripper.from_file(boxes_file, tcp=(0, 0, 0.03))
    assert json.loads(mine.model_dump_json())["tcp"] == [0, 0, 0.03]


def test_a_file_that_cannot_be_used_is_a_problem_of_the_configuration():
    with pytest.raises(UserError, match=r"grippers\.mine: none\.urdf: there is no such file"):
        check({"grippers": {"mine": {"file": "none.urdf"}}})
