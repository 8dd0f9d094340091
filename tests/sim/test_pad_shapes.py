"""What pads hold, from their shape and friction: slip loads against hand calculation.

F is the force of the hand at each pad, mu its friction and phi its friction angle, atan mu.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from worlds import EACH_FAST_ENGINE, hand_at, pull, start

from egad import Gripper
from egad._util.arrays import Floats
from egad.bench.tips import FingertipDesign
from egad.bench.tips.base import base_of
from egad.bench.tips.checks import hand_with_tips
from egad.bench.tips.solids import make_tips, union_of_hulls
from egad.friction import PADS
from egad.geometry import Bundle, to_mesh
from egad.sim.arms import HandPose
from egad.sim.model import Model, build
from egad.sim.parameters import EngineName
from egad.sim.world import TIME_STEP, WEIGHTLESS, Pose

F, MU = 20.0, 0.3
PHI = np.arctan(MU)
DEPTH, HALF = 3.5, 6.0  # mm, of V grooves
SLOPE = np.arctan(DEPTH / HALF)
# The friction of both engines is exact to some percent, and the force grows while things slip.
ERROR = 0.12
RAMP = 40.0  # N/s
HEIGHT = 0.3  # metres
EXACT = Bundle(deviation=1e-5, max_vertices=1000)
BALL = build(trimesh.creation.icosphere(4, 0.015), 400.0, EXACT)
RADIUS = 8.0  # mm, of the cylinder
CYLINDER = build(trimesh.creation.cylinder(RADIUS / 1000, 0.03, sections=72), 1200.0, EXACT)
DOWN, ASIDE = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])  # along and across the pads

Profile = Sequence[tuple[float, float]]


def slab(profile: Profile, half: float = 18.0, along: str = "z") -> Floats:
    """A convex piece with a cross-section of corners (x, t), from -half to half, mm."""
    corners = [(x, t, s) if along == "z" else (x, s, t) for x, t in profile for s in (-half, half)]
    return np.array(corners, dtype=float)


def arc(radius: float, facets: int) -> list[tuple[float, float]]:
    """Facets of a tenth of a radian on a circle through (0, 0), whose middle is at (-radius, 0)."""
    angles = 0.1 * (np.arange(facets + 1) - facets / 2)
    return [(radius * (np.cos(each) - 1), radius * np.sin(each)) for each in angles]


def hollow(radius: float, facets: int) -> list[Floats]:
    """A trough along z, whose edge is at x = 0."""
    points = [(-x, y) for x, y in arc(radius, facets)]
    edge = points[-1][0]
    return [
        slab([(-edge - 8, a[1]), (a[0] - edge, a[1]), (b[0] - edge, b[1]), (-edge - 8, b[1])])
        for a, b in pairwise(points)
    ]


GROOVED = [
    slab([(-8, -10), (-DEPTH, -10), (-DEPTH, 10), (-8, 10)]),
    *(slab([(-DEPTH - 0.01, way * y) for y in (10, 0)] + [(0, way * 10), (0, way * HALF)])
      for way in (-1, 1)),
]  # fmt: skip
PAD_SHAPES = {
    "flat": [slab([(-8, -10), (0, -10), (0, 10), (-8, 10)], 10)],
    "bulging": [slab([(-8, -12), (-8, 12), *arc(20, 11)], along="y")],
    "hollow": hollow(25, 13),
}


def hand_of(folder: Path, meshes: Sequence[trimesh.Trimesh]) -> Gripper:
    """Fingers that slide along x, each with these collision meshes, mm, whose face is at x = 0."""
    text = """<link name="palm"><collision><origin xyz="0 0 -0.06"/><geometry>
      <box size="0.1 0.04 0.02"/></geometry></collision></link>"""
    for name, way, mimic in (("first", -1, ""), ("second", 1, '<mimic joint="first"/>')):
        shapes = ""
        for number, mesh in enumerate(meshes):
            mirrored = mesh.copy().apply_transform(np.diag([-way / 1000, 1e-3, 1e-3, 1.0]))
            mirrored.export(folder / f"{name}-{number}.stl")
            shapes += f"""<collision><geometry><mesh filename="{name}-{number}.stl"/></geometry>
              </collision>"""
        text += f"""<link name="{name}_finger">{shapes}</link>
          <joint name="{name}" type="prismatic"><parent link="palm"/>
          <child link="{name}_finger"/><axis xyz="{way} 0 0"/>{mimic}
          <limit lower="0" upper="0.04" effort="9" velocity="1"/></joint>"""
    path = folder / "hand.urdf"
    path.write_text(f'<robot name="hand">{text}</robot>')
    return Gripper.from_file(path, force=F, pads="bare", friction=MU)


def of_pieces(folder: Path, pieces: Sequence[Floats]) -> Gripper:
    return hand_of(folder, [trimesh.convex.convex_hull(each) for each in pieces])


def with_grooved_tips(folder: Path) -> Gripper:
    """Boxes with fingertips that have a groove along the approach, as `egad design` writes them."""
    base = base_of("boxes", Gripper(opening=0.09, force=F, pads="bare", friction=MU))
    groove = {"groove_angle": np.degrees(SLOPE), "groove_depth": DEPTH / 1000}
    design = FingertipDesign(length=0.036, width=0.02, thickness=0.008, **groove)
    return hand_with_tips(base, design, make_tips(base, design), folder)


def of_one_mesh(folder: Path) -> Gripper:
    """Fingers that are one concave mesh each."""
    return hand_of(folder, [to_mesh(union_of_hulls(GROOVED))])


GROOVED_HANDS = {"tips": with_grooved_tips, "mesh": of_one_mesh}
EACH_GROOVE = pytest.mark.parametrize("grooved", GROOVED_HANDS)


def slip_load(
    engine: EngineName,
    gripper: Gripper,
    model: Model,
    way: Floats,
    aside: float = 0.0,
    way_out: float = 1e-3,
) -> tuple[float, float]:
    """The force by which a weightless object is pulled `way_out` metres away, and the opening.

    The middle of the object is beside that of the pads by `aside`, metres.
    """
    with start(engine, model, gripper) as world:
        world.set_gravity(WEIGHTLESS)
        upright = Rotation.from_matrix(model.to_principal[:3, :3].T).as_quat()
        world.place(Pose(np.array([0.0, aside, HEIGHT]), upright))
        tip = HandPose(0.0, 0.0, HEIGHT - (gripper.fingertip or 0.0), 0.0)
        hand = hand_at(world, tip, gripper.opening)
        hand.close()
        assert hand.pinches()
        world.step(60)
        opening, first = hand.opening(), world.pose().position
        for number in range(1000):
            force = RAMP * TIME_STEP * number
            pull(world, (force * way).tolist())
            world.step()
            if np.linalg.norm(world.pose().position - first) > way_out:
                return force, opening
    raise AssertionError("it was never pulled out")


@EACH_FAST_ENGINE
@EACH_GROOVE
def test_a_cylinder_in_v_grooves(engine: EngineName, grooved: str, tmp_path: Path) -> None:
    """Along the groove, four flanks carry F / (2 cos a) each; across it, it climbs two of them."""
    gripper = GROOVED_HANDS[grooved](tmp_path)
    along, opening = slip_load(engine, gripper, CYLINDER, DOWN)
    across, _ = slip_load(engine, gripper, CYLINDER, ASIDE)
    assert along == pytest.approx(2 * MU * F / np.cos(SLOPE), rel=ERROR)
    assert across == pytest.approx(2 * F * np.tan(SLOPE + PHI), rel=ERROR)
    assert 1000 * opening == pytest.approx(2 * (RADIUS / np.cos(SLOPE) - DEPTH), abs=0.5)


@EACH_FAST_ENGINE
@pytest.mark.parametrize("shape", PAD_SHAPES)
def test_a_ball_between_flat_and_curved_pads(
    engine: EngineName, shape: str, tmp_path: Path
) -> None:
    """It touches each pad at one point, whose normal is the closing axis."""
    gripper = of_pieces(tmp_path, PAD_SHAPES[shape])
    load, _ = slip_load(engine, gripper, BALL, DOWN)
    assert load == pytest.approx(2 * MU * F, rel=ERROR)


@EACH_FAST_ENGINE
def test_a_ball_leaves_a_trough_over_its_steepest_facets(
    engine: EngineName, tmp_path: Path
) -> None:
    """Those of the edge lean by 0.6 radians."""
    gripper = of_pieces(tmp_path, PAD_SHAPES["hollow"])
    load, _ = slip_load(engine, gripper, BALL, ASIDE, way_out=0.012)
    assert load == pytest.approx(2 * F * np.tan(0.6 + PHI), rel=ERROR)


@EACH_FAST_ENGINE
@pytest.mark.parametrize("radius", [10.0, 15.0])
def test_a_ball_in_v_grooves(engine: EngineName, radius: float, tmp_path: Path) -> None:
    """A small one rests on the flanks, as a cylinder; a large one on the edges of the groove."""
    ball = build(trimesh.creation.icosphere(4, radius / 1000), 400.0, EXACT)
    gripper = with_grooved_tips(tmp_path)
    slope = min(SLOPE, np.arcsin(HALF / radius))
    along, _ = slip_load(engine, gripper, ball, DOWN)
    across, _ = slip_load(engine, gripper, ball, ASIDE)
    assert along == pytest.approx(2 * MU * F / np.cos(slope), rel=ERROR)
    assert across == pytest.approx(2 * F * np.tan(slope + PHI), rel=ERROR)


@pytest.mark.parametrize("aside", [0.02, 0.04])
def test_a_plate_held_off_its_middle(aside: float, tmp_path: Path) -> None:
    """Friction bears its weight W, and with an effective radius r of the pads the moment W aside.

    So (W / 2 mu F)^2 (1 + (aside / r)^2) = 1. Even pressure on squares of 20 mm has r = 7.65 mm;
    with all of it at the corners, where MuJoCo presses, and the torsion of round contacts there,
    15.5 mm. PyBullet puts nearly all of it on one point, and holds less than even pressure does.
    """
    gripper = of_pieces(tmp_path, PAD_SHAPES["flat"])
    plate = build(trimesh.creation.box((0.01, 0.12, 0.04)), 500.0, EXACT)
    load, _ = slip_load("mujoco", gripper, plate, DOWN, aside)
    torsion = 2 / 3 * PADS["bare"].radius
    even, corners = 0.3826 * 0.02, 0.01 * np.sqrt(2) + torsion
    low, high = (2 * MU * F / np.hypot(1, aside / each) for each in (even, corners))
    assert (1 - ERROR) * low < load < (1 + ERROR) * high
