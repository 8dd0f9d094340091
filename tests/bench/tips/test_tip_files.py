"""A hand with fingertips, written and read again, and what is wrong with bad ones."""

from dataclasses import replace

import numpy as np
import pytest
from described_hands import box_urdf, jaw_urdf, linkage_mjcf

from egad import Gripper
from egad.bench.tips import FingertipDesign, TipLimits
from egad.bench.tips.base import base_of
from egad.bench.tips.checks import hand_with_tips, tip_problems
from egad.bench.tips.design import write_prints
from egad.bench.tips.files import write_hand
from egad.bench.tips.solids import make_tips
from egad.errors import UserError
from egad.grippers import joint_limits, model_of
from egad.io import read_mesh

PLA = 1240.0
SHORT = FingertipDesign(length=0.02, gap=0.02)
HANDS = {
    "turns": lambda folder: jaw_urdf(folder / "turns.urdf"),
    "mirrored": lambda folder: jaw_urdf(folder / "mirrored.urdf", mirrored=True),
    "slides": lambda folder: jaw_urdf(folder / "slides.urdf", slides=True),
    "mimics": lambda folder: box_urdf(folder / "mimics.urdf"),
    "linkage": lambda folder: linkage_mjcf(folder / "linkage.xml"),
    "two drives": lambda folder: box_urdf(folder / "drives.urdf", mimic=False),
}


@pytest.mark.parametrize("name", HANDS)
def test_a_hand_without_tips_is_read_as_it_was(tmp_path, name):
    gripper = Gripper.from_file(HANDS[name](tmp_path), force=10)
    base = base_of(name, gripper)
    path = write_hand(base, [], tmp_path / "out")
    limits = joint_limits(path)
    for joint in base.model.joints:
        assert limits[joint] == pytest.approx(base.limits[joint], abs=1e-6)
    for file in (path, path.with_suffix(".xml")):
        again = model_of(Gripper.from_file(file, force=10))
        assert [link.name for link in again.links[:2]] == [
            link.name for link in base.model.links[:2]
        ]
        np.testing.assert_allclose(again.openings, base.model.openings, atol=2e-5)
        np.testing.assert_allclose(again.positions, base.model.positions, atol=5e-4)
        np.testing.assert_allclose(again.palm_to_hand, base.model.palm_to_hand, atol=1e-5)
        assert again.joints == base.model.joints


@pytest.mark.parametrize("name", HANDS)
def test_plates_reduce_the_opening_or_keep_the_torque(tmp_path, name):
    gripper = Gripper.from_file(HANDS[name](tmp_path), force=10)
    base = base_of(name, gripper)
    tips = make_tips(base, SHORT)
    hand = hand_with_tips(base, SHORT, tips, tmp_path / "out")
    model = model_of(hand)
    masses = [sum(link.mass for link in each.links) for each in (base.model, model)]
    plastic = PLA * sum(tip.mesh.volume for tip in tips)
    assert masses[1] - masses[0] == pytest.approx(plastic, abs=3.1e-3)  # links have a gram at least
    assert model.openings[0] < 1.5e-3
    if base.turns:
        assert hand.force < gripper.force
        assert hand.force * model.lever == pytest.approx(gripper.force * base.model.lever)
        parallel = float(np.interp(0.0, model.angles, model.openings))
        assert parallel == pytest.approx(SHORT.gap, abs=3e-4)
    else:
        assert hand.force == gripper.force
        assert hand.opening == pytest.approx(gripper.opening - 2 * SHORT.thickness, abs=3e-4)


def test_a_hand_of_boxes_gets_a_file(tmp_path):
    base = base_of("boxes", Gripper(opening=0.08, force=30))
    hand, problems = tip_problems(base, SHORT, TipLimits(bend=0.01), tmp_path)
    assert problems == []
    assert hand.opening == pytest.approx(0.072, abs=1e-6)
    assert (hand.force, hand.pads) == (30, "silicone")


def problems_of(base, folder, limits=None, **design):
    _, problems = tip_problems(base, FingertipDesign(**design), limits or TipLimits(), folder)
    return " | ".join(problems)


def test_each_fault_has_its_sentence(tmp_path):
    jaw = base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10))
    assert problems_of(jaw, tmp_path / "good", length=0.02, gap=0.02) == ""
    thin = problems_of(jaw, tmp_path / "thin", length=0.02, gap=0.02, thickness=0.0009)
    assert "the first tip cannot be printed: its plate has walls thinner than 1.2 mm" in thin
    assert "the plates bend" in thin
    far = problems_of(jaw, tmp_path / "far", length=0.02, gap=0.06)
    assert "plates that are parallel at 60 mm need 68 mm" in far
    wide = problems_of(
        jaw, tmp_path / "wide", TipLimits(smallest=0.2, force=20, mass=0.001), length=0.02, gap=0.02
    )
    assert "less than the smallest object is thick: 200.0 mm" in wide
    assert "10.0 N without tips; at least 20.0 N are needed" in wide
    assert "the tips weigh 6 g, allowed: 1" in wide
    slides = base_of("box", Gripper.from_file(box_urdf(tmp_path / "box.urdf"), force=10))
    assert "the jaws with the tips meet where the hand is" in problems_of(
        slides, tmp_path / "tilted", TipLimits(smallest=0.001), length=0.04, angle=-20
    )


def test_a_problem_does_not_name_where_files_were_written(tmp_path):
    jaw = base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10))
    found = {
        problems_of(jaw, tmp_path / folder, length=0.012, thickness=0.0057, gap=0.03, angle=-14)
        for folder in ("one", "two")
    }
    (problem,) = found
    assert problem == "there is no face of the fixed jaw at its tcp"


def test_a_jaw_that_stops_early_does_not_close_fully(tmp_path):
    path = box_urdf(tmp_path / "stops.urdf", changes={'lower="0"': 'lower="0.006"'})
    base = base_of("stops", Gripper.from_file(path, force=10))
    found = problems_of(base, tmp_path / "out", length=0.02, thickness=0.0035)
    assert "the hand does not close fully: its tips stay 5.2 mm apart" in found


def test_a_linkage_out_of_proportion_is_refused(tmp_path, monkeypatch):
    gripper = Gripper.from_file(linkage_mjcf(tmp_path / "linkage.xml"), force=10)
    model = model_of(gripper)
    bent = model.positions.copy()
    bent[:, 1] += 0.05 * np.sin(np.linspace(0, np.pi, len(bent)))
    monkeypatch.setattr("egad.bench.tips.base.model_of", lambda _: replace(model, positions=bent))
    with pytest.raises(UserError, match=r"the hand mine: its joint .* does not follow .* linkage"):
        base_of("mine", gripper)


def test_the_grip_decides_how_wide_a_jaw_that_turns_opens(tmp_path):
    base = base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10))
    found = []
    for grip in (0.2, 0.8):
        design = FingertipDesign(length=0.03, gap=0.02, grip=grip)
        tips = make_tips(base, design)
        hand = hand_with_tips(base, design, tips, tmp_path / str(grip))
        found.append((hand.opening, hand.force, hand.fingertip))
    (wide, strong, behind), (narrow, weak, ahead) = found
    assert wide > narrow
    assert strong > weak  # its lever is shorter
    assert tips[0].free >= 0.03  # the jaws end 1.8 mm apart
    assert behind - ahead == pytest.approx(0.6 * tips[0].free, abs=1e-5)


def test_tips_lie_on_the_bed_without_support_and_apart(tmp_path):
    base = base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10))
    for length, angle in ((0.03, 8.0), (0.045, 0.0)):
        tips = make_tips(base, FingertipDesign(length=length, gap=0.02, angle=angle))
        write_prints(tips, tmp_path, "jaw")
        bodies = read_mesh(tmp_path / "tips.3mf", None).split()
        assert [body.extents[2] < 0.03 for body in bodies] == [True] * 2
        (_, end), (start, _) = sorted(tuple(body.bounds[:, 0]) for body in bodies)
        assert start > end


def test_a_hand_that_is_set_to_open_less_is_refused(tmp_path):
    gripper = Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10, opening=0.02)
    with pytest.raises(UserError, match=r"the hand jaw is set to open 20\.0 of"):
        base_of("jaw", gripper)


@pytest.mark.parametrize("mount", ["screw", "join"])
def test_how_tips_are_mounted_does_not_change_the_hand(tmp_path, mount):
    base = base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"), force=10))
    limits = TipLimits(mass=0.0062)  # kilograms; whole jaws weigh 21 g
    hands = []
    for each in ("glue", mount):
        design = SHORT.model_copy(update={"mount": each})
        hand, problems = tip_problems(base, design, limits, tmp_path / each)
        assert problems == []
        hands.append(hand)
    assert hands[0].opening == hands[1].opening
    texts = [(tmp_path / each / "hand.urdf").read_text() for each in ("glue", mount)]
    assert texts[0] == texts[1]
