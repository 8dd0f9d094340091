"""Attempts: what succeeds, what fails and how, and that each can be repeated alone."""

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.settings import GRIPPERS, POLICIES, Gripper, Material, Trials
from egad.stage_settings import SimulatedTrials
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad.trials.camera import View
from egad.trials.child import DetectorTimeoutError
from egad.trials.grasp import Grasp
from egad.trials.model import build
from egad.trials.policies import QUICK, Detector
from egad.trials.protocol import Attempt, Bench, run
from egad.trials.world import World

SETTINGS = SimulatedTrials(
    seed=1,
    gripper=GRIPPERS["egad_75mm"],
    policy=POLICIES["antipodal-depth"],
    material=Material(),
    trials=Trials(attempts=6),
)
CUBE = trimesh.creation.box((0.04, 0.04, 0.04))


def tried(mesh: trimesh.Trimesh, settings: SimulatedTrials = SETTINGS) -> pd.DataFrame:
    return run(mesh, "C4", "object", QUICK["antipodal-depth"], settings)


def ell() -> trimesh.Trimesh:
    long = trimesh.creation.box(bounds=[(0, 0, 0), (0.07, 0.03, 0.03)])
    wide = trimesh.creation.box(bounds=[(0, 0, 0), (0.03, 0.06, 0.03)])
    return trimesh.boolean.union([long, wide], engine="manifold")


def always(shift: tuple[float, float, float], width: float = 0.07) -> Detector:
    """A detector that knows only where the object is, and grasps beside its top by `shift`."""

    def detect(view: View, _gripper: Gripper, _rng: np.random.Generator, /) -> list[Grasp]:
        points = view.points().reshape(-1, 3)
        standing = points[points[:, 2] > 0.005]
        x, y, z = standing.mean(axis=0) * [1, 1, 0] + [0, 0, standing[:, 2].max()] + shift
        return [Grasp((float(x), float(y), float(z)), 0.0, width, 0.0, 1.0)]

    return detect


def outcome(
    mesh: trimesh.Trimesh, detect: Detector, density: float = 400.0, **gripper: float
) -> Attempt:
    hand = GRIPPERS["egad_75mm"].model_copy(update=gripper)
    with World(build(mesh, density, 8, 0.05)) as world:
        return Bench(world, hand, Trials()).attempt(detect, 5)


@pytest.mark.parametrize(
    "mesh",
    [CUBE, trimesh.creation.icosphere(4, 0.025), trimesh.creation.cylinder(0.02, 0.07)],
    ids=["cube", "ball", "cylinder"],
)
def test_simple_shapes_are_mostly_held(mesh: trimesh.Trimesh) -> None:
    trials = tried(mesh)
    assert trials["success"].sum() >= 5
    held = trials[trials["success"]]
    np.testing.assert_allclose(held["lifted"], SETTINGS.trials.lift_height, atol=0.01)


def test_an_object_far_wider_than_the_opening_is_never_held() -> None:
    trials = tried(trimesh.creation.box((0.15, 0.15, 0.12)))
    assert set(trials["outcome"]) <= {"no_grasp", "collided"}
    assert not trials["success"].any()
    assert (trials["lifted"].abs() < 0.01).all()


def test_the_table_is_complete(tmp_path_factory: pytest.TempPathFactory) -> None:
    trials = tried(CUBE)
    path = tmp_path_factory.mktemp("trials") / "trials.parquet"
    parquet.write(trials, TRIALS, path)
    pd.testing.assert_frame_equal(parquet.read(path, TRIALS), trials, check_dtype=False)
    assert trials["attempt"].tolist() == list(range(6))
    assert trials["seed"].str.fullmatch("[0-9a-f]{32}").all()
    assert trials["seed"].is_unique
    assert set(trials["label"]) == {"C4"}
    assert set(trials["parts"]) == {1}


def test_the_same_settings_give_the_same_bytes() -> None:
    mesh = ell()
    pd.testing.assert_frame_equal(tried(mesh), tried(mesh), check_exact=True)


def test_an_attempt_can_be_repeated_alone_from_its_seed() -> None:
    mesh = ell()
    trials = tried(mesh)
    trial = SETTINGS.trials
    model = build(mesh, SETTINGS.material.density, trial.max_parts, trial.volume_error)
    for number in (4, 1):
        row = trials.iloc[number]
        with World(model) as world:
            bench = Bench(world, SETTINGS.gripper, trial)
            again = bench.attempt(QUICK["antipodal-depth"], int(row["seed"], 16))
        assert again.outcome == row["outcome"]
        assert again.lifted == row["lifted"]
        assert again.grasp is not None
        assert again.grasp.center == (row["grasp_x"], row["grasp_y"], row["grasp_z"])


def test_another_seed_drops_differently() -> None:
    first, second = tried(CUBE), tried(CUBE, SETTINGS.model_copy(update={"seed": 2}))
    assert (first["seed"] != second["seed"]).all()
    assert (first["grasp_x"] != second["grasp_x"]).all()


def test_the_drop_does_not_depend_on_the_detector() -> None:
    places = []
    with World(build(CUBE, 400.0, 8, 0.05)) as world:
        bench = Bench(world, SETTINGS.gripper, SETTINGS.trials)

        def thirsty(view: View, _gripper: Gripper, rng: np.random.Generator, /) -> list[Grasp]:
            rng.random(len(places) * 10)
            places.append(view.depth)
            return []

        for _ in range(2):
            assert bench.attempt(thirsty, 3).outcome == "no_grasp"
    np.testing.assert_array_equal(*places)


def test_a_grasp_at_the_middle_succeeds() -> None:
    attempt = outcome(CUBE, always((0, 0, -0.03)))
    assert attempt.outcome == "success"


def test_a_grasp_beside_the_object_misses() -> None:
    attempt = outcome(CUBE, always((0, 0.1, -0.03)))
    assert attempt.outcome == "missed"
    assert attempt.lifted == pytest.approx(0, abs=0.001)


def test_a_finger_on_top_of_the_object_collides() -> None:
    assert outcome(CUBE, always((0.035, 0, -0.03))).outcome == "collided"


def test_too_heavy_an_object_slips() -> None:
    attempt = outcome(CUBE, always((0, 0, -0.03)), density=2.5 / 0.04**3, force=20.0)
    assert attempt.outcome == "slipped"
    assert attempt.lifted < 0.05


@pytest.mark.parametrize(
    ("shift", "width", "name"),
    [
        ((0, 0, -0.03), 0.2, "too_wide"),
        ((0, 0, -0.03), -0.01, "too_wide"),
        ((0, 0, -0.03), np.inf, "not_finite"),
        ((0, np.nan, 0), 0.07, "not_finite"),
        ((0, 0, -0.1), 0.07, "below_table"),
    ],
)
def test_a_grasp_that_the_hand_cannot_do_is_named(
    shift: tuple[float, float, float], width: float, name: str
) -> None:
    attempt = outcome(CUBE, always(shift, width))
    assert (attempt.outcome, attempt.grasp, attempt.lifted) == (name, None, 0.0)


@pytest.mark.parametrize("answer", [None, 3, ["grasp"], [(0, 0, 0)]])
def test_an_answer_that_is_no_list_of_grasps_is_an_error(answer: object) -> None:
    assert outcome(CUBE, lambda *_: answer).outcome == "error"  # type: ignore[arg-type,return-value]


def test_a_detector_that_raises_has_failed_and_the_next_attempt_goes_on() -> None:
    calls = []

    def moody(view: View, gripper: Gripper, rng: np.random.Generator, /) -> list[Grasp]:
        calls.append(1)
        if len(calls) == 1:
            raise ZeroDivisionError
        return always((0, 0, -0.03))(view, gripper, rng)

    trials = run(CUBE, "A0", "object", moody, SETTINGS)
    assert trials["outcome"].tolist()[0] == "error"
    assert trials["outcome"].tolist()[1:].count("error") == 0
    assert trials["success"].any()


def test_a_detector_that_takes_too_long_has_failed() -> None:
    def slow(*_: object) -> list[Grasp]:
        raise DetectorTimeoutError

    assert outcome(CUBE, slow).outcome == "timeout"


def test_what_cannot_be_simulated_fails_and_does_not_stop_the_rest() -> None:
    trials = tried(trimesh.Trimesh(CUBE.vertices, CUBE.faces[1:], process=False))
    assert len(trials) == SETTINGS.trials.attempts
    assert set(trials["outcome"]) == {"failed"}
    assert set(trials["parts"]) == {0}


def test_an_object_larger_than_the_view_fails() -> None:
    huge = trimesh.creation.box((0.5, 0.5, 0.5))
    assert outcome(huge, always((0, 0, 0))).outcome == "failed"
