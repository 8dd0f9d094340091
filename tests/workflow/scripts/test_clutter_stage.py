"""Tables of a bundle are cleared, whatever the engine and the detector do."""

import os
import signal
from contextlib import contextmanager

import clutter
import numpy as np
import pandas as pd
import pytest
import trimesh
from commands import egad
from PIL import Image
from report import scene_pictures

from egad import sample_grasps
from egad.bench import (
    ClearedTables,
    ClutterParameters,
    Reproduction,
    failed_round,
    film_clearing,
    groups_of,
    proposed_by,
    rounds_of,
    run_round,
    verify_groups,
)
from egad.errors import UserError
from egad.exchange import any_objects, bundle_models, model_in, rows_by_id, write_bundle
from egad.io import write_obj
from egad.sim import SimulationBundle
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, GRASP_POSE
from egad.tables.outcomes import Outcome
from egad_workflow.settings import Settings, select

GRIPPER = "egad_75mm"
FEW = {"rounds": 2, "objects": 2, "noise": ["none"], "scenes": ["packed", "pile"]}
WHOLE = Settings.model_validate({"clutter": FEW})
MESHES = {
    f"box{number}": trimesh.creation.box(sides)
    for number, sides in enumerate([(0.04, 0.03, 0.05), (0.03, 0.06, 0.03), (0.04, 0.04, 0.04)])
}
OWN = """
import os, signal, time
import numpy as np
from egad.detectors import GraspPoses


def at_the_highest_point(cloud, gripper, rng):
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = cloud.points[cloud.points[:, 2].argmax()] - [0, 0, 0.01]
    return GraspPoses(pose[None], np.array([gripper.opening]), np.ones(1))


def late(cloud, gripper, rng):
    time.sleep(60)


def dying(cloud, gripper, rng):
    os.kill(os.getpid(), signal.SIGSEGV)


def failing(cloud, gripper, rng):
    return 1 / 0


def misnamed(point_cloud, gripper, rng):
    return []


def answering_nonsense(cloud, gripper, rng):
    return "up"
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of a bundle."""
    folder = tmp_path_factory.mktemp("results")
    for name, mesh in MESHES.items():
        write_obj(mesh, folder / f"{name}.obj")
    items = any_objects([folder / f"{name}.obj" for name in MESHES])
    write_bundle(select(WHOLE, SimulationBundle), items, "m", folder / "bundle" / GRIPPER)
    return folder / "bundle" / GRIPPER


def settings(detector, **changes):
    detectors = {"own": {"detector": detector}}
    targets = {"detectors": ["own"]}
    whole = {"clutter": FEW | changes, "detectors": detectors, "targets": targets}
    return select(Settings.model_validate(whole), ClearedTables, GRIPPER, "own")


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    path = tmp_path_factory.mktemp("code") / "own.py"
    path.write_text(OWN)
    return path


def cleared(given, made, out, shard=(0, 1), keep_going=False):
    clutter.run(given, made, shard, out, keep_going=keep_going)
    return parquet.read(out, CLUTTER)


@pytest.fixture(scope="module")
def table(made, own, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "own.parquet"
    return cleared(settings(f"{own}:at_the_highest_point"), made, out)


def test_shards_together_are_the_whole(table, made, own, tmp_path):
    given = settings(f"{own}:at_the_highest_point")
    parts = [cleared(given, made, tmp_path / f"{i}.parquet", (i, 3)) for i in range(3)]
    order = ["scene", "noise", "round", "attempt"]
    joined = pd.concat(parts).sort_values(order, ignore_index=True)
    pd.testing.assert_frame_equal(joined, table.sort_values(order, ignore_index=True))
    assert table["success"].any()


def test_it_is_what_the_library_does_in_this_process(table, made, own):
    """The detector is in a process of its own and the simulation in another one."""
    space = {}
    exec(own.read_text(), space)  # noqa: S102
    given = select(WHOLE, ClutterParameters, GRIPPER)
    models = {name: model_in(made, row) for name, row in rows_by_id(made).items()}
    propose = proposed_by(space["at_the_highest_point"], given.gripper)
    expected = [
        run_round(this, models, lambda *_: propose, given) for this in rounds_of(models, given)
    ]
    pd.testing.assert_frame_equal(pd.concat(expected, ignore_index=True), table, check_dtype=False)


@pytest.mark.parametrize(
    ("name", "limit", "outcome"),
    [("late", 0.3, "timeout"), ("dying", 60.0, "error"), ("answering_nonsense", 60.0, "error")],
)
def test_what_a_detector_does_wrong_is_an_outcome_and_the_run_goes_on(
    made, own, tmp_path, name, limit, outcome
):
    given = settings(f"{own}:{name}", rounds=1, scenes=["packed"])
    given = given.model_copy(update={"planning_time": limit})
    found = cleared(given, made, tmp_path / "out.parquet", keep_going=True)
    assert found["outcome"].tolist() == [outcome, outcome]  # two in a row end a round
    assert (found["failure"] != "").all()


def test_a_detector_that_only_fails_stops_the_run_and_leaves_its_traceback(made, own, tmp_path):
    given = settings(f"{own}:failing", scenes=["packed"], rounds=4)
    with pytest.raises(UserError, match=r"all 6 attempts of the first 3 rounds") as stopped:
        cleared(given, made, tmp_path / "out.parquet")
    line = OWN[: OWN.index("1 / 0")].count("\n") + 1
    kept = tmp_path / "out.parquet.failure.txt"
    assert str(stopped.value).endswith(f"was written to {kept}")
    text = kept.read_text(encoding="utf-8")
    assert f'File "{own.name}", line {line}, in failing' in text
    assert text.endswith("ZeroDivisionError: division by zero\n")
    assert not (tmp_path / "out.parquet").exists()


def test_a_detector_that_asks_for_something_unknown_stops_the_run_at_once(made, own, tmp_path):
    with pytest.raises(UserError, match=r"'point_cloud' is none of view, views, cloud"):
        cleared(settings(f"{own}:misnamed"), made, tmp_path / "out.parquet")


def test_a_round_that_kills_the_engine_is_marked(made, monkeypatch, tmp_path):
    given = settings("random", rounds=1, scenes=["pile"])
    monkeypatch.setattr(clutter, "open_clutter", deadly)
    clutter.run(given, made, (0, 1), tmp_path / "out.parquet")
    found = parquet.read(tmp_path / "out.parquet", CLUTTER)
    assert found["outcome"].tolist() == ["crashed"]
    assert found["n_objects"].tolist() == [0]


@contextmanager
def deadly(*_):
    yield lambda _: os.kill(os.getpid(), signal.SIGABRT)


def test_labels_need_grasps(made, tmp_path):
    with pytest.raises(UserError, match="`labels` needs the table of labelled grasps"):
        clutter.run(settings("labels"), made, (0, 1), tmp_path / "out.parquet")


def test_tables_are_cleared_with_known_grasps(made, tmp_path):
    """Boxes that lie apart: each has grasps in a file that is named after it."""
    (tmp_path / "known").mkdir()
    for name, mesh in MESHES.items():
        poses = sample_grasps(mesh, GRIPPER, n=100).poses
        np.savez(tmp_path / "known" / name, poses=poses, frame="x z", depth=0.0, units="m")
    given = settings(f"grasps:{tmp_path / 'known'}", scenes=["packed"])
    found = cleared(given, made, tmp_path / "out.parquet")
    assert found["success"].mean() > 0.7


@pytest.mark.usefixtures("small_films")
def test_a_round_is_filmed_again(table, made, tmp_path):
    given = select(WHOLE, ClutterParameters, GRIPPER)
    path = tmp_path / "own.parquet"
    parquet.write(table, CLUTTER, path)
    film_clearing(given, path, bundle_models(made), ("pile", "none", 0), tmp_path / "film.gif")
    frames = Image.open(tmp_path / "film.gif").n_frames
    assert frames > 20 * table.query("scene == 'pile' and round == 0")["success"].sum()
    with pytest.raises(UserError, match="not in the table"):
        film_clearing(given, path, bundle_models(made), ("pile", "none", 2), tmp_path / "film.gif")
    altered = table.assign(success=~table["success"])
    parquet.write(altered, CLUTTER, path)
    with pytest.raises(UserError, match="not reproduced"):
        film_clearing(given, path, bundle_models(made), ("pile", "none", 0), tmp_path / "film.gif")


def test_pictures_show_scenes_of_each_kind(made):
    given = select(WHOLE, ClutterParameters, GRIPPER)
    found = scene_pictures(given, made)
    assert {kind: len(each) for kind, each in found.items()} == {"packed": 2, "pile": 2}
    assert len({png for each in found.values() for png in each}) == 4


@pytest.mark.usefixtures("small_films")
def test_commands_benchmark_and_compare(own, tmp_path, monkeypatch):
    for name, mesh in MESHES.items():
        write_obj(mesh, tmp_path / "objects" / f"{name}.obj")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "few.yaml").write_text(f"clutter: {FEW}")
    common = (
        "--objects objects --units m --rule none --config few.yaml --rounds 1 --jobs 1 --gripper"
    )
    rows = []
    for text in (
        f"{own}:at_the_highest_point {common} {GRIPPER} --films films",
        f"random {common} {GRIPPER}",
    ):
        done = egad("benchmark", *text.split())
        assert done.returncode == 0, done.stderr
        rows += [line.split() for line in done.stdout.splitlines()]
    assert {tuple(row[:3]) for row in rows} >= {
        ("own", "mujoco", "packed"),
        ("own", "mujoco", "pile"),
        ("random", "mujoco", "pile"),
    }
    assert {path.name for path in (tmp_path / "films").iterdir()} == {
        "own-packed.gif",
        "own-pile.gif",
    }
    tables = ["benchmark/own.parquet", "benchmark/random.parquet"]
    assert "own vs random" in egad("trials", "compare", *tables).stdout
    one, other = (parquet.read(tmp_path / path, CLUTTER) for path in tables)
    same = ["scene", "seed", "objects", "n_objects"]
    first, second = (each[each["attempt"] == 0][same].to_numpy().tolist() for each in (one, other))
    assert first == second
    assert parquet.origin_of(tmp_path / tables[0])["stage"] == "benchmark"
    assert np.isfinite(one["score"]).any()


def groups(table):
    return groups_of(table, None, 0)


def test_rounds_are_verified_and_altered_ones_told(table, made):
    given = select(WHOLE, ClutterParameters, GRIPPER)
    models = {name: model_in(made, row) for name, row in rows_by_id(made).items()}
    assert verify_groups(groups(table), models, given) == Reproduction(len(table), same=len(table))
    row = table.index[table["success"]][0]
    altered = table.copy()
    altered.loc[row, "success"] = False
    (found,) = verify_groups(groups(altered), models, given).unexplained
    assert (found.column, found.said, found.simulated) == ("success", False, True)
    whole_round = table["round"].eq(1) & table["scene"].eq("pile")
    reseeded = table.assign(seed=table["seed"].mask(whole_round, "0" * 32))
    found = verify_groups(groups(reseeded), models, given).impossible[0]
    assert (found.place, found.column) == ("round 1, pile, noise none, attempt 0", "seed")


def test_rounds_that_were_cut_short_or_added_to_are_told(table, made):
    """Failures at the end of a round that are left out would raise the success rate."""
    given = select(WHOLE, ClutterParameters, GRIPPER)
    models = bundle_models(made)
    last = table.groupby(["scene", "noise", "round"], sort=False).tail(1)
    (found,) = verify_groups(groups(table.drop(last.index[0])), models, given).impossible
    count = int(last["attempt"].iloc[0]) + 1
    assert (found.column, found.said, found.simulated) == ("number of attempts", count - 1, count)
    more = last.iloc[[0]].assign(attempt=count)
    (found,) = verify_groups(groups(pd.concat([table, more])), models, given).impossible
    assert (found.said, found.simulated) == (count + 1, count)


def test_a_success_without_a_grasp_and_another_number_of_objects_are_told(table, made):
    given, models = select(WHOLE, ClutterParameters, GRIPPER), bundle_models(made)
    row = table.index[table["success"]][0]
    without = table.copy()
    without.loc[row, list(GRASP_POSE)] = np.nan
    found = verify_groups(groups(without), models, given).impossible
    assert [(each.column, each.simulated) for each in found] == [("outcome", "no grasp was tried")]
    fewer = table.assign(n_objects=table["n_objects"].where(table.index != row, 9))
    (found,) = verify_groups(groups(fewer), models, given).unexplained
    assert (found.column, found.said) == ("n_objects", 9)


def test_a_round_that_began_cannot_be_said_to_have_failed(table, made):
    """Rounds that failed do not count, so bad ones would be left out."""
    given, models = select(WHOLE, ClutterParameters, GRIPPER), bundle_models(made)
    this = rounds_of(list(models), given)[0]
    failed = failed_round(this, given, Outcome.FAILED)
    others = table[~(table["scene"].eq(this.scene) & table["round"].eq(this.number))]
    verdict = verify_groups(groups(pd.concat([failed, others])), models, given)
    assert [each.place for each in verdict.unexplained] == [
        f"round 0, {this.scene}, noise {this.noise}, attempt 0"
    ]
    assert not verdict.is_honest


def test_a_failure_cannot_be_said_to_be_one_of_the_simulation(table, made):
    """Those do not count either."""
    given, models = select(WHOLE, ClutterParameters, GRIPPER), bundle_models(made)
    last = table.groupby(["scene", "noise", "round"], sort=False).tail(1).index[0]
    failed = table.copy()
    failed.loc[last, [*GRASP_POSE, "width", "score", "stopped"]] = np.nan
    failed.loc[last, ["success", "outcome"]] = False, "failed"
    verdict = verify_groups(groups(failed), models, given)
    assert [each.column for each in verdict.impossible] == ["outcome"]
