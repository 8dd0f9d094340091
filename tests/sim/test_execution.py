"""A lift and a hold end early only where they would end in the same way."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from worlds import EACH_ARM, EACH_ENGINE, EACH_FAST_ENGINE, HAND, start

from egad.bench import Attempt, TrialProtocol, TrialRunner
from egad.detectors.base import Grasp
from egad.detectors.registry import QUICK
from egad.geometry import Bundle
from egad.sim.arms import ARMS
from egad.sim.execution import ContactRules, Execution, Stillness, execute
from egad.sim.model import Model, build
from egad.sim.parameters import EngineName
from egad.sim.world import TIME_STEP, Pose, World
from egad.tables.outcomes import Outcome

BUNDLE = Bundle()
SIDE = 0.04
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
Motion = Callable[[float], tuple[float, float, float]]


def still_from(motion: Motion, start: float = 0.0, end: float = 2.0) -> float | None:
    """Seconds until an object of 40 mm is still that sinks, turns and is squeezed as given.

    Args:
        motion: Metres, radians and metres at a time.
        start: Of `Stillness`.
        end: Of `Stillness`.
    """
    now = [0.0]

    def pose() -> Pose:
        sunk, angle, _ = motion(now[0])
        half = angle / 2
        return Pose(np.array([0.0, 0.0, 0.5 - sunk]), np.array([np.sin(half), 0, 0, np.cos(half)]))

    mesh = trimesh.creation.box((SIDE,) * 3)
    world = SimpleNamespace(model=SimpleNamespace(mesh=mesh), pose=pose)
    hand = SimpleNamespace(
        world=world, height=lambda: 0.4, opening=lambda: SIDE - motion(now[0])[2]
    )
    still = Stillness(hand, start, end)  # type: ignore[arg-type]
    for step in range(1, round(end / TIME_STEP) + 1):
        now[0] = step * TIME_STEP
        if still():
            return now[0]
    return None


def test_what_does_not_move_is_still_after_a_tenth_of_a_second() -> None:
    assert still_from(lambda _: (0.0, 0.0, 0.0)) == pytest.approx(0.1)
    for begin in (0.3, 0.31, 0.32):
        found = still_from(lambda _: (0.0, 0.0, 0.0), start=begin)
        assert found == pytest.approx(begin + 0.1, abs=0.01)


@pytest.mark.parametrize(
    "motion",
    [
        lambda time: (0.001 * time, 0.0, 0.0),  # 1 mm/s
        lambda time: (0.0, 0.04 * time, 0.0),  # a corner at 1.4 mm/s
        lambda time: (0.0, 0.0, 0.001 * time),
        lambda time: (0.01 * time**2, 0.0, 0.0),
        lambda time: (0.0, 0.03 * np.cos(time / 0.07), 0.0),  # swings by 2 degrees, as 5 cm do
    ],
    ids=["sinks", "turns", "is squeezed", "sinks faster", "swings"],
)
def test_what_slips_slowly_is_not_still(motion: Motion) -> None:
    found = still_from(motion)
    assert found is None or found > 0.9  # of 2 s: then too little time is left to go far


def test_what_slips_and_then_sticks_is_still_once_it_sticks() -> None:
    found = still_from(lambda time: (0.01 * min(time, 0.5), 0.0, 0.0))
    assert found == pytest.approx(0.6, abs=0.03)


def held_up(
    engine: EngineName,
    density: float,
    arm: str,
    shift: float = 0.0,
    force: float = 20.0,
    lift: float = 0.4,
    watch: Callable[[World], None] | None = None,
) -> Execution:
    """A cube of 40 mm grasped between pads of friction 0.5, beside its middle."""
    gripper = HAND.model_copy(update={"force": force, "friction": 0.5})
    model = build(trimesh.creation.box((SIDE,) * 3), density, BUNDLE)
    with start(engine, model, gripper, arm) as world:
        world.watch = watch
        world.place(Pose(np.array([0.0, 0.0, SIDE / 2]), UPRIGHT))
        grasp = Grasp((0.0, shift, 0.02), 0.0, 0.065, 0.01, 1.0)
        return execute(world, ARMS[arm](gripper), TrialProtocol(lift_height=lift), grasp)


@EACH_FAST_ENGINE
@EACH_ARM
def test_a_hand_that_meets_the_table_closes_there_if_the_protocol_says_so(
    engine: EngineName, arm: str
) -> None:
    """A cube grasped with the fingertips 10 mm below the table."""
    model = build(trimesh.creation.box((SIDE,) * 3), 400.0, BUNDLE)
    grasp = Grasp((0.0, 0.0, 0.02), 0.0, 0.065, 0.03, 1.0)
    found = {}
    for closes in (False, True):
        with start(engine, model, arm=arm) as world:
            world.place(Pose(np.array([0.0, 0.0, SIDE / 2]), UPRIGHT))
            stopping = ContactRules("close" if closes else "collided", 10.0)
            found[closes] = execute(world, ARMS[arm](HAND), TrialProtocol(), grasp, rules=stopping)
    assert found[False].outcome == Outcome.COLLIDED
    assert found[True].outcome == Outcome.SUCCESS
    for each in found.values():
        assert each.stopped == pytest.approx(0.01, abs=0.004)


def in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on everything is lifted all the way and held as long as it says."""
    monkeypatch.setattr(Stillness, "__call__", lambda _: False)


@EACH_FAST_ENGINE
@pytest.mark.parametrize(("arm", "spared"), [("axis", 1.2), ("panda", 0.75)])
def test_what_is_held_firmly_is_not_simulated_to_the_end(
    engine: EngineName, arm: str, spared: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the axis most of the lift is left out with the hold; an arm is lifted all the way.

    Args:
        engine: What computes it.
        arm: What carries the hand.
        spared: Part of the time of holding that is left out at least.
    """
    steps = []

    def counted(simulate: Callable[..., None]) -> Callable[..., None]:
        return lambda world, count=1: steps.append(count) or simulate(world, count)

    monkeypatch.setattr(World, "step", counted(World.step))
    case = (engine, 0.2 / SIDE**3, arm)
    assert held_up(*case).outcome == "success"
    early = sum(steps)
    in_full(monkeypatch)
    assert held_up(*case).outcome == "success"
    assert sum(steps) - 2 * early > spared * TrialProtocol().hold_time / TIME_STEP


@EACH_ENGINE
def test_what_is_taken_out_of_a_hand_on_the_axis_is_dropped(engine: EngineName) -> None:
    """It is lifted so shortly that the hand still has to hold it until it lies still."""
    lift, lifted = 0.03, []

    def take(world: World) -> None:
        lifted.append(world.pose().position[2] > SIDE / 2 + lift - 0.0005)
        if sum(lifted) == 10:
            world.place(Pose(np.array([0.2, 0.0, 0.3]), UPRIGHT))

    case = (engine, 0.2 / SIDE**3, "axis")
    assert held_up(*case, lift=lift).outcome == "success"
    assert held_up(*case, lift=lift, watch=take).outcome == "dropped"


@EACH_FAST_ENGINE
@EACH_ARM
def test_loads_around_what_friction_carries_end_as_if_simulated_in_full(
    engine: EngineName, arm: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pads of 20 N carry 2.04 kg at rest, and 1.73 kg when the hand speeds up most."""
    masses = (0.5, 1.7, 1.75, 1.8, 2.1) if arm == "axis" else (1.5, 1.7, 1.8, 2.1)
    cases = [(engine, mass / SIDE**3, arm) for mass in masses]
    early = [held_up(*case) for case in cases]
    in_full(monkeypatch)
    full = [held_up(*case) for case in cases]
    assert [each.outcome for each in early] == [each.outcome for each in full]
    assert len({each.outcome for each in full}) > 1
    for one, other in zip(early, full, strict=True):
        assert one.lifted == pytest.approx(other.lifted, abs=0.001)


def attempts(engine: EngineName, model: Model, count: int) -> list[Attempt]:
    gripper = HAND.model_copy(update={"force": 8.0})
    with start(engine, model, gripper) as world:
        runner = TrialRunner(world, ARMS["axis"](gripper), TrialProtocol())
        return [runner.attempt(QUICK["random"], seed) for seed in range(count)]


@EACH_FAST_ENGINE
@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.icosphere(3, 0.025),
        trimesh.creation.box((0.02, 0.03, 0.09)),
        trimesh.creation.torus(0.03, 0.01, 24, 12),
    ],
    ids=["ball", "bar", "ring"],
)
def test_attempts_end_as_if_simulated_in_full(
    engine: EngineName, mesh: trimesh.Trimesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Random grasps in a weak hand: some hold, some slip."""
    model = build(mesh, 1500.0, BUNDLE)
    early = attempts(engine, model, 5)
    in_full(monkeypatch)
    full = attempts(engine, model, 5)
    assert [each.outcome for each in early] == [each.outcome for each in full]
    for one, other in zip(early, full, strict=True):
        assert one.lifted == pytest.approx(other.lifted, abs=0.001)
