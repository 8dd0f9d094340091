"""The rules of published benchmarks do what their names say."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from standing_cube import CUBE, DOWN, SIDE, UPRIGHT, grasp, stand
from test_clearing_runner import MODELS, from_above, in_turn, knowing, nowhere
from worlds import EACH_FAST_ENGINE, HAND

from egad.bench import (
    NAMED_PROTOCOLS,
    Clutter,
    ClutterParameters,
    ClutterProtocol,
    RestingObject,
    Round,
    SceneCameras,
    camera_poses,
    intrinsics_of,
    open_round,
    proposed_by,
    rounds_of,
)
from egad.bench.clearing_runner import ClearingRunner
from egad.bench.runner import Attempt, Propose
from egad.detectors import Grasp, GraspPoses, Observation
from egad.errors import UserError
from egad.grippers import GRIPPERS
from egad.random import generator
from egad.sim.engines import open_world
from egad.sim.execution import ContactRules, execute_pose
from egad.sim.parameters import EngineName
from egad.sim.robots import free_hand
from egad.sim.world import Pose
from egad.tables.outcomes import Outcome

PANDA = GRIPPERS["panda"]


def clear(propose: Propose, protocol: ClutterProtocol, noise: str = "none") -> list[Attempt]:
    with open_world("mujoco", MODELS, free_hand(HAND)) as world:
        runner = ClearingRunner(world, Clutter(protocol=protocol))
        return list(runner.clear(propose, "packed", noise, 3))  # type: ignore[arg-type]


def rounds(**settings: object) -> list[tuple[tuple[str, ...], tuple[float, ...]]]:
    clutter = Clutter(rounds=200, scenes=("packed", "pile"), noise=("none",), **settings)
    known = ClutterParameters(seed=0, gripper=PANDA, clutter=clutter)
    return [(each.ids, each.factors) for each in rounds_of(list("abcdefg"), known)]


def test_cameras_stand_where_vgn_and_giga_put_them() -> None:
    """By hand: 0.6 m from (0, 0, -0.05), 30 degrees off the vertical, sixty degrees apart.

    GIGA's is at the side, below in a picture from above: sin 60 = 0.8660, cos 60 = 0.5.
    """
    poses = camera_poses(NAMED_PROTOCOLS["vgn"].cameras, generator(0, "test"))
    expected = [
        [0.3, 0.0, 0.469615],
        [0.15, 0.259808, 0.469615],
        [-0.15, 0.259808, 0.469615],
        [-0.3, 0.0, 0.469615],
        [-0.15, -0.259808, 0.469615],
        [0.15, -0.259808, 0.469615],
    ]
    np.testing.assert_allclose([pose[:3, 3] for pose in poses], expected, atol=1e-6)
    for pose in poses:
        np.testing.assert_allclose(pose[:3, 3] + 0.6 * pose[:3, 2], [0, 0, -0.05], atol=1e-12)
    (side,) = camera_poses(NAMED_PROTOCOLS["giga"].cameras, generator(0, "test"))
    np.testing.assert_allclose(side[:3, 3], [0, -0.519615, 0.35], atol=1e-6)
    np.testing.assert_allclose(side[:3, 3] + 0.6 * side[:3, 2], [0, 0, 0.05], atol=1e-12)


@pytest.mark.parametrize(("name", "vertical"), [("egad", 59.9887), ("vgn", 47.9250)])
def test_the_field_of_view_is_as_published(name: str, vertical: float) -> None:
    camera = intrinsics_of(NAMED_PROTOCOLS[name].cameras)
    top = (camera.center[1] + 0.5) / camera.focal
    assert 2 * np.degrees(np.arctan(top)) == pytest.approx(vertical, abs=1e-3)
    assert camera.center == ((camera.width - 1) / 2, (camera.height - 1) / 2)


@EACH_FAST_ENGINE
def test_a_contact_on_the_way_closes_fails_or_is_ignored(engine: EngineName) -> None:
    """The left finger comes down on a heavy cube, and the hand is 10 mm off its middle.

    Where it is stopped, both fingers are above the cube, and close on nothing.
    """
    results = {}
    with open_world(engine, [CUBE], free_hand(HAND)) as world:
        for contact in ("close", "collided", "ignore"):
            world.reset()
            stand(world, SIDE)
            pose = grasp([0.045, 0, 0.02], [1, 0, 0], DOWN)
            results[contact] = execute_pose(world, pose, 0.07, ContactRules(contact))
    assert results["close"].stopped == results["collided"].stopped > 0
    assert results["close"].outcome == results["collided"].outcome == Outcome.COLLIDED
    assert results["ignore"].stopped == 0
    assert results["ignore"].outcome != Outcome.COLLIDED


def test_a_touch_suffices_under_the_rules_of_vgn() -> None:
    """One finger presses on two objects once the hand has gone back, and never the other one."""
    with open_world("mujoco", [CUBE, CUBE, CUBE], free_hand(HAND)) as world:
        for number, x in enumerate((0.5, 0.7, 0.9)):
            world.place(Pose(np.array([x, 0, SIDE / 2]), UPRIGHT), number=number)
        pose = grasp([0, 0, 0.1], [1, 0, 0], DOWN)
        real = world.forces

        def forces(number: int | None = None) -> object:
            found = real(number)
            if world.arm_joints()[2] > -0.04 or number == 0:
                return found
            return found._replace(left={None: 3.0, 1: 1.0, 2: 2.0}[number])

        outcomes = {}
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(world, "forces", forces)
            patch.setattr(type(world), "close_fingers", lambda _: None)
            for pinched, first in ((True, False), (False, False), (False, True)):
                rules = ContactRules("ignore", pinched=pinched, first=first)
                found = execute_pose(world, pose, 0.07, rules)
                outcomes[pinched, first] = found.outcome, found.held
    assert outcomes[True, False] == (Outcome.MISSED, None)
    assert outcomes[False, False] == (Outcome.SUCCESS, 2)
    assert outcomes[False, True] == (Outcome.SUCCESS, 1)


def test_the_hand_opens_fully_if_the_protocol_says_so() -> None:
    """A narrow opening comes down on the block; the full one goes around it."""

    def narrow(_: Observation, present: Sequence[RestingObject], __: object) -> Grasp:
        return replace(knowing(_, present, __), width=0.01)  # type: ignore[arg-type]

    first = {
        opening: clear(narrow, ClutterProtocol(opening=opening))[0]  # type: ignore[arg-type]
        for opening in ("predicted", "full")
    }
    assert first["predicted"].outcome == Outcome.COLLIDED
    assert first["full"].outcome == Outcome.SUCCESS
    assert first["full"].grasp is not None
    assert first["full"].grasp.width == 0.01  # what was asked for


def test_skips_look_again_and_are_no_failures() -> None:
    seen: list[np.ndarray] = []

    def none(observation: Observation, *_: object) -> Outcome:
        seen.append(observation.views[0].pose)
        return Outcome.NO_GRASP

    def outcomes(protocol: ClutterProtocol, *proposals: Propose) -> list[Outcome]:
        return [each.outcome for each in clear(in_turn(*proposals), protocol)]

    three = ClutterProtocol(skips=3, cameras=SceneCameras(views=1, azimuth=(0.0, 180.0)))
    nothing, missed, won = Outcome.NO_GRASP, Outcome.MISSED, Outcome.SUCCESS
    assert outcomes(three, none, none, none, knowing) == [nothing] * 3
    assert len({pose.tobytes() for pose in seen}) == 3
    found = outcomes(three, none, nowhere, none, nowhere, knowing)
    assert found == [nothing, missed, nothing, missed]
    found = outcomes(three, none, knowing, none, knowing, none)
    assert found == [nothing, won, nothing, won, nothing]
    assert outcomes(ClutterProtocol(), none, knowing) == [nothing]
    once = ClutterProtocol(failures=1)
    assert outcomes(once, nowhere, knowing) == [missed]


def test_a_round_with_skips_is_repeated() -> None:
    rules = ClutterProtocol(skips=2, opening="full", contact="collided")
    with open_world("mujoco", MODELS, free_hand(HAND)) as world:
        runner = ClearingRunner(world, Clutter(protocol=rules))
        propose = in_turn(lambda *_: Outcome.NO_GRASP, knowing, nowhere, nowhere)
        attempts = list(runner.clear(propose, "packed", "none", 3))
        tried = [each.grasp or each.outcome for each in attempts]
        again = list(runner.repeat(tried, "packed", 3))
    for one, other in zip(attempts, again, strict=True):
        assert (one.outcome, one.held) == (other.outcome, other.held)
        for before, after in zip(one.present, other.present, strict=True):
            np.testing.assert_array_equal(before.pose.position, after.pose.position)


def chosen_scores(protocol: ClutterProtocol, scores: list[float], draws: int = 300) -> list[float]:
    """The scores of the grasps that are tried; of no grasp, 0."""
    poses = np.tile(from_above(np.array([0, 0, 0.1]), np.array([1.0, 0, 0])).pose, (8, 1, 1))

    def detect(view: object, _gripper: object, _rng: object) -> GraspPoses:
        del view
        return GraspPoses(poses[: len(scores)], np.full(len(scores), 0.05), np.array(scores))

    propose = proposed_by(detect, HAND, protocol)
    seen = Observation(None, (), 0.3)  # type: ignore[arg-type]
    found = [propose(seen, [], generator(number, "test")) for number in range(draws)]
    return [each.quality if isinstance(each, Grasp) else 0.0 for each in found]


def test_the_chosen_grasp_is_the_highest_or_a_random_one_above_the_threshold() -> None:
    scores = [0.4, 0.92, 0.97, 0.95, 0.6]
    assert set(chosen_scores(NAMED_PROTOCOLS["egad"], scores)) == {0.97}
    assert set(chosen_scores(NAMED_PROTOCOLS["giga"], scores)) == {0.97}
    values, counts = np.unique(chosen_scores(NAMED_PROTOCOLS["vgn"], scores), return_counts=True)
    assert values.tolist() == [0.92, 0.95, 0.97]
    assert ((counts > 70) & (counts < 130)).all()  # 300 / 3, give or take 3.7 standard deviations
    for name, low in (("egad", 0.6), ("giga", 0.6), ("edgegrasp", 0.6), ("vgn", 0.0)):
        assert set(chosen_scores(NAMED_PROTOCOLS[name], [0.4, 0.6], 9)) == {low}
    assert set(chosen_scores(NAMED_PROTOCOLS["giga"], [0.4], 3)) == {0.0}
    assert set(chosen_scores(NAMED_PROTOCOLS["egad"], [0.4], 3)) == {0.4}


def test_objects_are_drawn_with_repetition_and_in_the_sizes_of_each_scene() -> None:
    ours, published = rounds(), rounds(protocol="vgn")
    assert all(len(set(ids)) == 5 for ids, _ in ours)
    # All five differ with a chance of 7! / 2! / 7^5 = 0.150.
    assert np.mean([len(set(ids)) == 5 for ids, _ in published]) == pytest.approx(0.15, abs=0.06)
    half = len(published) // 2
    for part, low, high in ((published[:half], 0.7, 0.9), (published[half:], 0.8, 1.0)):
        factors = np.array([each for _, each in part])
        assert low <= factors.min() < low + 0.005
        assert high - 0.005 < factors.max() <= high
    assert {len(ids) for ids, _ in rounds(protocol="vgn", objects=12)} == {12}
    assert {len(ids) for ids, _ in rounds(objects=12)} == {7}


def test_points_are_noisy_and_images_are_not() -> None:
    seen = {}

    def look(observation: Observation, *_: object) -> Outcome:
        seen[noise] = observation
        return Outcome.NO_GRASP

    for noise in ("none", "points"):
        clear(look, ClutterProtocol(), noise)
    for one, other in zip(seen["none"].views, seen["points"].views, strict=True):
        np.testing.assert_array_equal(one.depth, other.depth)
    exact = replace(seen["points"], point_sigma=0.0).cloud.points
    np.testing.assert_array_equal(exact, seen["none"].cloud.points)
    fine = seen["none"].fuse_views(120).surface()[0]
    rng = np.random.default_rng(seen["points"].point_seed)
    moved = fine + 0.0008 * rng.standard_normal(fine.shape)
    np.testing.assert_allclose(seen["points"].cloud.points, moved[moved[:, 2] > 0.004])


def test_a_protocol_is_known_by_its_name_and_another_one_is_custom() -> None:
    for name, rules in NAMED_PROTOCOLS.items():
        assert (rules.name, str(rules)) == (name, name)
        assert Clutter(protocol=name).protocol == rules
    assert ClutterProtocol(skips=2).name == "custom"
    assert Clutter(protocol={"skips": 2}).protocol.skips == 2
    assert Clutter(protocol="giga").noises == ("dex",)
    assert Clutter(protocol="giga", noise=("none",)).noises == ("none",)
    hand = {"force": 20.0, "friction": 1.0}
    assert NAMED_PROTOCOLS["vgn"].model_dump(include=set(hand)) == hand


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("gpd", "protocol is 'gpd'; allowed: egad, vgn, giga, edgegrasp, or a section with"),
        ({"contact": "bounce"}, "bounce"),
        ({"scale": [0.9, 0.8]}, "from a positive low to high"),
        ({"cameras": {"tilt": [60, 95]}}, "less than 90 degrees"),
    ],
)
def test_what_is_no_protocol_is_named(given: object, text: str) -> None:
    with pytest.raises((ValueError, UserError), match=text):
        Clutter(protocol=given)  # type: ignore[arg-type]


@EACH_FAST_ENGINE
def test_the_hand_has_the_force_and_the_pads_of_the_protocol(engine: EngineName) -> None:
    this = Round("single", "none", 0, 0, ("cube",), (1.0,))
    for name, force, friction in (("egad", 70.0, 0.8), ("edgegrasp", 20.0, 0.75)):
        clutter = Clutter(protocol=name, engine=engine)
        settings = ClutterParameters(seed=0, gripper=PANDA, clutter=clutter)
        with open_round(this, {"cube": CUBE}, settings) as world:
            assert world.robot is not None
            assert world.robot.gripper.force == force
            assert world.robot.gripper.pad.friction == friction
