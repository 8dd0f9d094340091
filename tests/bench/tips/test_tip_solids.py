"""Solids of fingertips against volumes and distances calculated by hand."""

import numpy as np
import pytest
import trimesh
from described_hands import jaw_urdf

from egad import Gripper
from egad.bench.tips import FingertipDesign
from egad.bench.tips.base import base_of, pose_of
from egad.bench.tips.checks import bending
from egad.bench.tips.solids import make_tips, union_of_hulls
from egad.errors import UserError
from egad.geometry import to_solid
from egad.grippers import SuctionCup

LENGTH, WIDTH, THICK, OVERLAP = 0.025, 0.016, 0.004, 0.012
PLAIN = {"length": LENGTH, "width": WIDTH, "thickness": THICK, "overlap": OVERLAP}


def boxes():
    return base_of("boxes", Gripper(opening=0.08, finger_width=0.02, finger_thickness=0.01))


def jaw(tmp_path, **options):
    return base_of("jaw", Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf", **options), force=10))


def volumes(base, **changes):
    tips = make_tips(base, FingertipDesign(**PLAIN | changes))
    return [float(tip.mesh.volume) for tip in tips]


def test_volumes_of_plates_of_a_hand_of_boxes():
    plate = WIDTH * THICK * (OVERLAP + LENGTH)
    assert volumes(boxes()) == pytest.approx([plate] * 2)
    assert volumes(boxes(), bevel=0.002) == pytest.approx([plate - 0.002**2 / 2 * WIDTH] * 2)
    spacer = plate + 0.003 * WIDTH * OVERLAP
    assert volumes(boxes(), spacer=0.003) == pytest.approx([spacer] * 2)
    cross_section = 0.002**2 / np.tan(np.radians(30))
    for direction, long in (("along", OVERLAP + LENGTH), ("across", WIDTH)):
        groove = {"groove_angle": 30, "groove_depth": 0.002, "groove_direction": direction}
        assert volumes(boxes(), **groove) == pytest.approx([plate - cross_section * long] * 2)


def test_screw_holes_are_drilled_and_countersunk():
    """M3: 3.4 mm through plates of 4 mm, and heads of 6.3 mm at 90 degrees."""
    plate, deep, r, head = WIDTH * THICK * (OVERLAP + LENGTH), 1.45e-3, 1.7e-3, 3.15e-3
    cone = np.pi * deep * (r**2 + r * head + head**2) / 3
    hole = np.pi * r**2 * (THICK - deep) + cone
    assert volumes(boxes(), mount="screw") == pytest.approx([plate - 2 * hole] * 2, rel=1e-3)
    for tip in make_tips(boxes(), FingertipDesign(**PLAIN, mount="screw")):
        assert tip.mesh.is_watertight
        assert tip.mesh.euler_number == -2  # two holes
        assert tip.added.volume == pytest.approx(plate)


@pytest.mark.parametrize("slides", [False, True])
def test_joined_tips_are_the_jaw_and_the_tip(tmp_path, slides):
    base = jaw(tmp_path, slides=slides)
    glued, joined = (
        make_tips(base, FingertipDesign(**PLAIN, gap=0.02, mount=mount))
        for mount in ("glue", "join")
    )
    for one, both in zip(glued, joined, strict=True):
        own = union_of_hulls(base.model.links[one.link].shapes)
        assert both.mesh.is_watertight
        assert both.mesh.body_count == 1
        assert both.mesh.volume == pytest.approx(one.mesh.volume + own.volume(), rel=1e-6)
        assert both.added.volume == pytest.approx(one.mesh.volume)
        np.testing.assert_array_equal(both.pieces[-1], one.pieces[-1])  # simulated the same


@pytest.mark.parametrize("change", [{"width": 0.0149}, {"overlap": 0.0074}, {"thickness": 0.0026}])
def test_feet_too_small_for_screws_are_refused(change):
    message = r"two M3 screws need a foot that is 15 mm x 7\.5 mm x 2\.65 mm wide, long and,"
    with pytest.raises(UserError, match=message):
        make_tips(boxes(), FingertipDesign(**PLAIN | change, mount="screw"))


def test_a_tilted_plate_has_its_volume_and_its_pieces_fill_the_solid(tmp_path):
    for base in (boxes(), jaw(tmp_path)):
        tips = make_tips(
            base, FingertipDesign(**PLAIN, angle=8, groove_angle=20, groove_depth=0.001)
        )
        for tip in tips:
            groove = 0.001**2 / np.tan(np.radians(20)) * (OVERLAP + LENGTH)
            beyond = (
                union_of_hulls(tip.pieces[:-1]).volume()
                + groove
                - WIDTH * THICK * (OVERLAP + LENGTH)
            )
            assert beyond == pytest.approx(0, abs=2e-8 + WIDTH * THICK * 0.01)
            solid = to_solid(tip.mesh.vertices, tip.mesh.faces)
            hulls = [trimesh.convex.convex_hull(piece) for piece in tip.pieces]
            left = solid
            for hull in hulls:
                left -= to_solid(hull.vertices, hull.faces)
            assert left.volume() == pytest.approx(0, abs=1e-12)


def test_tips_do_not_reach_into_their_jaws(tmp_path):
    base = jaw(tmp_path)
    for tip in make_tips(base, FingertipDesign(**PLAIN, gap=0.02)):
        assert tip.mesh.is_watertight
        assert tip.mesh.body_count == 1
        own = to_solid(tip.mesh.vertices, tip.mesh.faces)
        for points in base.model.links[tip.link].shapes:
            hull = trimesh.convex.convex_hull(points)
            assert (own ^ to_solid(hull.vertices, hull.faces)).volume() == pytest.approx(
                0, abs=1e-11
            )


@pytest.mark.parametrize("gap", [0.015, 0.03])
def test_plates_of_a_jaw_that_turns_are_parallel_at_their_gap(tmp_path, gap):
    base = jaw(tmp_path)
    design = FingertipDesign(**PLAIN, gap=gap)
    first, second = make_tips(base, design)
    (number,) = [n for n, link in enumerate(base.model.links) if link.joint]
    angles, distances = [], []
    for opening in base.model.openings:
        one, other = (
            pose_of(base.model, link, float(opening)) @ tip.pose
            for tip, link in ((first, first.link), (second, number))
        )
        angles.append(np.arcsin(other[:3, 0] @ one[:3, 2]))
        between = (other - one) @ [THICK, 0, 0.03, 1]
        distances.append(between[:3] @ one[:3, 0])
    order = np.argsort(angles)
    assert min(angles) < 0 < max(angles)
    parallel = np.interp(0.0, np.array(angles)[order], np.array(distances)[order])
    assert parallel == pytest.approx(gap, abs=5e-5)


def test_tilted_plates_part_by_their_angle():
    for angle in (-6, 6):
        first, second = make_tips(boxes(), FingertipDesign(**PLAIN, angle=angle))
        ends = []
        for tip in (first, second):
            inner = tip.pieces[0] @ tip.pose[:3, :3] + np.linalg.inv(tip.pose)[:3, 3]
            ends.append(inner[inner[:, 2] > OVERLAP][:, 0].max() - THICK)
        expected = -LENGTH * np.sin(np.radians(angle / 2))
        assert ends == pytest.approx([expected] * 2, abs=2e-4)


def test_bending_is_that_of_a_cantilever():
    design = FingertipDesign(length=0.03, width=0.012, thickness=0.003)
    inertia = 0.012 * 0.003**3 / 12
    assert bending(design, 0.03, 5.0) == pytest.approx(5 * 0.03**3 / (3 * 2.3e9 * inertia))
    grooved = design.model_copy(update={"groove_angle": 20.0, "groove_depth": 0.001})
    assert bending(grooved, 0.03, 5.0) == pytest.approx(3.375 * bending(design, 0.03, 5.0))


def test_designs_without_room_are_refused(tmp_path):
    with pytest.raises(UserError, match=r"jaws are .* apart; plates that are parallel at 60 mm"):
        make_tips(jaw(tmp_path), FingertipDesign(gap=0.06))
    with pytest.raises(
        UserError, match=r"groove is 5 mm deep and 17\.3 mm wide, in plates that are 4 mm"
    ):
        make_tips(boxes(), FingertipDesign(groove_angle=30, groove_depth=0.005))
    with pytest.raises(UserError, match="16 mm wide there; make it shallower"):
        make_tips(boxes(), FingertipDesign(groove_angle=5, groove_depth=0.002))
    with pytest.raises(UserError, match="the bevel is 20 mm, the plates are 4 mm thick"):
        make_tips(boxes(), FingertipDesign(bevel=0.02))


def test_a_cup_has_no_jaws():
    with pytest.raises(UserError, match="the hand mine has a suction cup and no jaws"):
        base_of("mine", Gripper(cup=SuctionCup(radius=0.01)))


def test_the_model_of_boxes_is_that_of_their_body():
    gripper = Gripper(opening=0.06, finger_width=0.018, finger_thickness=0.007, finger_length=0.05)
    base = base_of("boxes", gripper)
    corners = np.concatenate(base.model.corners(0.04, -1))
    assert corners[:, 0].min() == pytest.approx(-0.02 - 0.007)
    assert corners[:, 0].max() == pytest.approx(-0.02)
    assert np.ptp(corners[:, 2]) == pytest.approx(0.05)
    assert base.limits == {"first_joint": (0.0, 0.03), "second_joint": (0.0, 0.03)}
