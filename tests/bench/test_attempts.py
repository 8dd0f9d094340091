"""Tables of attempts: complete, the same every time, each row enough to repeat its attempt."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import trimesh
from worlds import EACH_ENGINE, EACH_FAST_ENGINE, start

from egad.bench import (
    NAMED_ERRORS,
    TrialParameters,
    TrialProtocol,
    TrialRunner,
    columns_of,
    failed_attempts,
    read_attempt,
    run_attempts,
)
from egad.detectors import View
from egad.detectors.asking import Detector
from egad.detectors.base import Grasp
from egad.detectors.registry import QUICK
from egad.geometry import Bundle
from egad.grippers import GRIPPERS, Gripper
from egad.sim.arms import ARMS
from egad.sim.model import Model, build
from egad.sim.parameters import EngineName
from egad.tables import parquet
from egad.tables.columns import INITIAL
from egad.tables.evaluation import TRIALS
from egad.tables.outcomes import Outcome

BUNDLE = Bundle()
ROUND = Bundle(deviation=1e-5, max_vertices=1000)  # one part with all vertices
SETTINGS = TrialParameters(
    seed=1,
    gripper=GRIPPERS["egad_75mm"],
    trials=TrialProtocol(attempts=6, engine="mujoco"),
)
WITH_ERRORS = {
    "errors": NAMED_ERRORS["typical"],
    "contact": "close",
    "stopping_force": 10.0,
}
BALL = build(trimesh.creation.icosphere(3, 0.025), 400.0, ROUND)
CUBE, CYLINDER = (
    build(mesh, 400.0, BUNDLE)
    for mesh in (
        trimesh.creation.box((0.04, 0.04, 0.04)),
        trimesh.creation.cylinder(0.02, 0.07),
    )
)


@pytest.fixture(scope="module")
def ell() -> Model:
    long = trimesh.creation.box(bounds=[(0, 0, 0), (0.07, 0.03, 0.03)])
    wide = trimesh.creation.box(bounds=[(0, 0, 0), (0.03, 0.06, 0.03)])
    both = trimesh.boolean.union([long, wide], engine="manifold")
    return build(both, 400.0, BUNDLE)


def attempts(
    model: Model,
    detect: Detector = QUICK["antipodal-depth"],
    settings: TrialParameters = SETTINGS,
    **trials: object,
) -> pd.DataFrame:
    changed = settings.trials.model_copy(update=trials)
    return run_attempts(
        model, "C4", "object", detect, settings.model_copy(update={"trials": changed})
    )


def nothing(*_: object) -> list[Grasp]:
    return []


def clumsy(view: View, gripper: Gripper, rng: np.random.Generator, /) -> list[Grasp]:
    """Sometimes well, sometimes beside the object, sometimes onto it, sometimes not at all."""
    found = QUICK["antipodal-depth"](view, gripper, rng)
    if not found or rng.random() < 0.2:
        return []
    x, y, z = found[0].center
    along, aside = rng.choice([0.0, 0.015]), rng.choice([0.0, 0.025])
    cosine, sine = np.cos(found[0].angle), np.sin(found[0].angle)
    x, y = x + along * cosine - aside * sine, y + along * sine + aside * cosine
    return [replace(found[0], center=(x, y, z))]


@EACH_FAST_ENGINE
@pytest.mark.parametrize("model", [CUBE, BALL, CYLINDER], ids=["cube", "ball", "cylinder"])
def test_simple_shapes_are_mostly_held(engine: EngineName, model: Model) -> None:
    trials = attempts(model, engine=engine, depth_noise=0.1)
    assert set(trials["engine"]) == {engine}
    assert trials["success"].sum() >= 5
    held = trials[trials["success"]]
    np.testing.assert_allclose(held["lifted"], SETTINGS.trials.lift_height, atol=0.01)


def test_the_table_is_complete(tmp_path_factory: pytest.TempPathFactory) -> None:
    trials = attempts(CUBE)
    path = tmp_path_factory.mktemp("trials") / "trials.parquet"
    parquet.write(trials, TRIALS, path)
    pd.testing.assert_frame_equal(parquet.read(path, TRIALS), trials, check_dtype=False)
    assert trials["attempt"].tolist() == list(range(6))
    assert trials["seed"].str.fullmatch("[0-9a-f]{32}").all()
    assert trials["seed"].is_unique
    assert set(trials["label"]) == {"C4"}
    assert set(trials["parts"]) == {1}


@EACH_ENGINE
def test_the_same_settings_give_the_same_bytes(engine: EngineName, ell: Model) -> None:
    first, second = (attempts(ell, engine=engine) for _ in range(2))
    pd.testing.assert_frame_equal(first, second, check_exact=True)


@EACH_FAST_ENGINE
@pytest.mark.parametrize(
    "changes",
    [{}, {"arm": "panda"}, {"reset": "redrop"}, WITH_ERRORS],
    ids=["", "panda", "redrop", "errors"],
)
def test_every_attempt_can_be_repeated_alone(
    engine: EngineName,
    ell: Model,
    changes: dict[str, object],
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """From its row of the table, bit by bit, without the detector and the attempts before."""
    seeded = SETTINGS.model_copy(update={"seed": 3})
    trials = attempts(ell, clumsy, seeded, attempts=8, depth_noise=0.05, engine=engine, **changes)
    assert trials["outcome"].nunique() >= 3
    path = tmp_path_factory.mktemp("trials") / "trials.parquet"
    parquet.write(trials, TRIALS, path)
    trial = SETTINGS.trials.model_copy(update=changes)
    arm = ARMS[trial.arm](SETTINGS.gripper)
    for row in reversed(parquet.records(parquet.read(path, TRIALS))):
        with start(engine, ell, arm=trial.arm) as world:
            again = columns_of(
                TrialRunner(world, arm, trial).repeat(*read_attempt(row, trial.errors))
            )
        again["outcome"] = again["outcome"] or row["outcome"]
        np.testing.assert_equal(again, {name: row[name] for name in again})


def test_the_object_goes_on_where_the_attempt_before_left_it() -> None:
    trials = attempts(BALL, clumsy, attempts=20)
    begun = trials["initial_pose"].tolist()
    assert begun[0] == "dropped"
    assert set(begun) == {"dropped", "from_hand", "left"}
    for before, after in zip(trials.itertuples(), list(trials.itertuples())[1:], strict=False):
        assert (after.initial_pose == "from_hand") <= (before.outcome == "success")
        assert (before.outcome == "no_grasp") <= (after.initial_pose == "dropped")
        if after.initial_pose == "left":
            ends = [getattr(before, name.replace("initial", "end")) for name in INITIAL]
            assert ends == [getattr(after, name) for name in INITIAL]


def test_without_a_chain_two_detectors_face_the_same_drops(ell: Model) -> None:
    ways = [attempts(ell, detect, reset="redrop") for detect in (clumsy, nothing)]
    assert set(ways[0]["initial_pose"]) == {"dropped"}
    for name in INITIAL:
        assert ways[0][name].tolist() == ways[1][name].tolist()


def test_what_cannot_be_tried_has_rows_all_the_same(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    trials = failed_attempts("C4", "object", SETTINGS, Outcome.CRASHED)
    path = tmp_path_factory.mktemp("trials") / "trials.parquet"
    parquet.write(trials, TRIALS, path)
    pd.testing.assert_frame_equal(parquet.read(path, TRIALS), trials, check_dtype=False)
    assert trials["seed"].tolist() == attempts(CUBE, nothing)["seed"].tolist()
    assert set(trials["outcome"]) == {"crashed"}
    assert set(trials["parts"]) == {0}
    assert not trials["success"].any()
