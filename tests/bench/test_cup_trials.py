"""Trials and cleared tables with a suction cup: exact repeats, and refusals of what is for jaws."""

import pandas as pd
import pytest
import trimesh
from worlds import EACH_ENGINE, EACH_FAST_ENGINE

import egad
from egad.bench import (
    NAMED_ERRORS,
    NaiveGraspParameters,
    Reproduction,
    SceneKind,
    TrialParameters,
    TrialProtocol,
    run_attempts,
    try_naive_grasps,
    verify_attempts,
)
from egad.detectors.suction import suction_depth
from egad.errors import UserError
from egad.geometry import Bundle
from egad.grippers import GRIPPERS
from egad.sim.labelled_trials import execute_labelled_grasps
from egad.sim.model import build
from egad.sim.parameters import EngineName, LabelTrialParameters, SimulatedLabelParameters
from egad.sim.simulated_labels import simulate_grasps
from egad.tables.outcomes import Outcome

CUP = GRIPPERS["cup_30mm"]
MESHES = {
    "box": trimesh.creation.box((0.05, 0.06, 0.04)),
    "slab": trimesh.creation.box((0.09, 0.07, 0.03)),
}


@EACH_ENGINE
def test_attempts_are_repeated_from_their_table(engine: EngineName) -> None:
    trials = TrialProtocol(attempts=6, engine=engine, errors=NAMED_ERRORS["typical"])
    settings = TrialParameters(seed=1, gripper=CUP, trials=trials)
    model = build(MESHES["box"], 400.0, Bundle())
    table = run_attempts(model, "A0", "box", suction_depth, settings)
    assert (table["outcome"] == Outcome.SUCCESS).sum() >= 3
    assert (table["width"] == 0).all()
    assert verify_attempts(model, table, settings) == Reproduction(attempts=6, same=6)
    table.loc[2, "lifted"] += 0.1
    verdict = verify_attempts(model, table, settings)
    assert [each.column for each in verdict.unexplained] == ["lifted"]


@EACH_FAST_ENGINE
@pytest.mark.parametrize(
    ("detector", "scene"),
    [("labels", "packed"), ("suction-cloud", "packed"), ("suction-depth", "single")],
)
def test_detectors_clear_tables_of_boxes(
    engine: EngineName, detector: str, scene: SceneKind
) -> None:
    found = egad.run_benchmark(
        detector,
        MESHES,
        "cup_30mm",
        scenes=[scene],
        noise=["none"],
        rounds=2,
        per_scene=2,
        engine=engine,
        rule="none",
    )
    assert found.table["success"].mean() >= 0.7


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda: egad.run_trials("antipodal-depth", MESHES, CUP), "antipodal-depth is for jaws"),
        (lambda: egad.run_trials("suction-depth", MESHES, "panda"), "the gripper has jaws"),
        (
            lambda: egad.run_benchmark("antipodal-cloud", MESHES, CUP),
            "suction-cloud, suction-depth",
        ),
    ],
)
def test_what_is_for_another_kind_of_gripper_is_refused(run, words) -> None:
    with pytest.raises(UserError, match=words):
        run()


def test_what_is_simulated_with_jaws_alone_refuses_a_cup() -> None:
    model, nothing = build(MESHES["box"], 400.0, Bundle()), pd.DataFrame()

    def settings(kind):
        return kind.model_construct(gripper=CUP)

    for run in (
        lambda: try_naive_grasps(model, "box", settings(NaiveGraspParameters)),
        lambda: simulate_grasps(model, nothing, settings(SimulatedLabelParameters)),
        lambda: execute_labelled_grasps(model, "", "", nothing, settings(LabelTrialParameters)),
    ):
        with pytest.raises(UserError, match="needs a gripper with two jaws"):
            run()
