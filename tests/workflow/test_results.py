"""What the workflow makes: real runs on config/test.yaml."""

import hashlib
import os
import re
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import trimesh
from results_page import results
from rule_texts import ROOT, script_of

from egad import __version__
from egad.data import evaluation_set
from egad.io.sums import read_sums
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE, EVAL49, MANIFEST, TRIALS
from egad.tables.evolution import ARCHIVE, EPOCH, HISTORY, LINEAGE
from egad.tables.grasping import GRASPS, SAMPLING, SCALES, SIZE_EFFECT
from egad.tables.objects import COMPARISON, OBJECTS, REJECTED, SOLIDS
from egad_workflow.code_version import code_version
from egad_workflow.provenance import origin_of
from egad_workflow.settings import Settings
from egad_workflow.verify import verify

GRIPPER, DETECTOR = "egad_75mm", "antipodal-depth"
SCRIPTS = ROOT / "workflow/scripts"
SHARDS = EPOCHS = ISLANDS = 2
PUBLISHED = {
    "comparison.parquet": COMPARISON,
    "egad/archive.parquet": ARCHIVE,
    "egad/history.parquet": HISTORY,
    "egad/ancestry.parquet": LINEAGE,
    "egad/objects.parquet": OBJECTS,
    "egad/rejected.parquet": REJECTED,
    "egad/eval49.parquet": EVAL49,
    "egad/eval49.rejected.parquet": REJECTED,
    f"egad/grasps/{GRIPPER}.parquet": GRASPS,
    f"egad/grasps/{GRIPPER}.sampling.parquet": SAMPLING,
    f"egad/grasps/{GRIPPER}.rejected.parquet": REJECTED,
    f"egad/rescaled/{GRIPPER}/scales.parquet": SCALES,
    f"egad/rescaled/{GRIPPER}/rejected.parquet": REJECTED,
    f"egad/size_effect/{GRIPPER}.parquet": SIZE_EFFECT,
    f"egad/print/{GRIPPER}/manifest.parquet": MANIFEST,
    f"egad/bundle/{GRIPPER}/bundle.parquet": BUNDLE,
    f"egad/bundle/{GRIPPER}/rejected.parquet": REJECTED,
    f"egad/trials/{GRIPPER}/{DETECTOR}.parquet": TRIALS,
}
EPOCH_TABLES = {
    f"egad/epochs/epoch-{epoch}/{name}.parquet": schema
    for epoch in range(EPOCHS)
    for name, schema in {
        "archive": EPOCH,
        "island-0": EPOCH,
        "island-1": EPOCH,
        "history-0": HISTORY,
        "history-1": HISTORY,
        "lineage-0": LINEAGE,
        "lineage-1": LINEAGE,
    }.items()
}
PARTS = {
    f"egad/parts/{name}-{shard}.parquet": schema
    for shard in range(SHARDS)
    for name, schema in {
        "solids": SOLIDS,
        "rejected": REJECTED,
        f"grasps-{GRIPPER}": GRASPS,
        f"sampling-{GRIPPER}": SAMPLING,
        f"ungraspable-{GRIPPER}": REJECTED,
        f"trials-{GRIPPER}-{DETECTOR}": TRIALS,
    }.items()
}
TABLES = PUBLISHED | EPOCH_TABLES | PARTS


@pytest.fixture
def load(finished):
    """A published table of the finished run, by its path within results."""
    return lambda path: parquet.read(finished.results / path, TABLES[path])


@pytest.mark.parametrize("path", TABLES)
def test_every_table_is_there_with_columns_units_and_meanings(finished, tmp_path, path):
    parquet.write(parquet.empty(TABLES[path]), TABLES[path], tmp_path / "empty.parquet")
    expected = pq.read_schema(tmp_path / "empty.parquet")
    found = pq.read_schema(finished.results / path).remove_metadata()  # of the whole: the notes
    assert found.equals(expected, check_metadata=True)
    assert expected.names == TABLES[path].names


def test_there_are_no_other_tables_and_no_temporary_files(finished):
    made = {str(path.relative_to(finished.results)) for path in finished.results.rglob("*.parquet")}
    assert made == set(TABLES)
    assert not list(finished.results.rglob("*.partial"))


def test_every_file_is_in_the_manual(finished):
    """But for sums, and for what jobs pass to each other."""
    listed = [re.sub("[A-Z]+", "[^/]+", re.escape(each.path)) for each in results()]
    known = re.compile("|".join(f"{path}.*" if path.endswith("/") else path for path in listed))
    unknown = [
        path
        for path in finished.bytes()
        if not known.fullmatch(path)
        and not path.startswith(("egad/parts/", "egad/epochs/"))
        and not path.endswith(("SHA256SUMS", ".sha256"))
    ]
    assert unknown == []


@pytest.mark.parametrize("path", TABLES)
def test_every_table_says_what_it_was_made_by_and_from(finished, path):
    table = finished.results / path
    noted = origin_of(table)
    assert noted.program == __version__
    assert noted.code == code_version(SCRIPTS / f"{script_of(noted.stage)}.py")
    assert noted.sources() or noted.seed == Settings().seed
    assert all(source.exists() for source, _ in noted.sources())
    assert str(finished.folder) not in str(pq.read_schema(table).metadata)
    assert Settings().seed in {each.seed for each in ancestors(table)}


def ancestors(path):
    """What was noted of a file and of all that it was made from."""
    noted = origin_of(path)
    if noted is None:
        return
    yield noted
    for source, _ in noted.sources():
        yield from ancestors(source)


def test_a_finished_run_is_as_it_was_made(finished):
    verdict = verify(finished.results)
    assert (verdict.problems, verdict.unknown, verdict.gone) == ({}, [], 0)


def test_altered_files_are_found_and_named(copy):
    altered = ["egad/archive.parquet", f"egad/print/{GRIPPER}/plate-1.3mf"]
    for path in altered:
        data = bytearray((copy.results / path).read_bytes())
        data[len(data) // 2] ^= 1
        (copy.results / path).write_bytes(data)
    problems = verify(copy.results).problems
    assert {problems[copy.results / path] for path in altered} == {"altered"}


def test_the_history_tells_of_every_step_and_ends_with_the_archive(load):
    history = load("egad/history.parquet")
    steps = [(e, i, s) for e in range(EPOCHS) for i in (0, 1) for s in (0, 1)]
    assert list(zip(history["epoch"], history["island"], history["step"], strict=True)) == steps
    assert (history["offspring"] == 10).all()
    assert (history["refined"] <= history["evaluated"]).all()
    assert history["refined"].sum() > 0
    assert history["elites"].iloc[-1] <= len(load("egad/archive.parquet"))


def test_the_second_epoch_begins_with_what_the_first_one_found(load):
    second = load("egad/epochs/epoch-1/history-0.parquet")
    assert second["elites"].iloc[0] >= len(load("egad/epochs/epoch-0/archive.parquet"))


def test_every_elite_descends_from_random_genomes(load):
    born = load("egad/ancestry.parquet").set_index("id")
    archive = load("egad/archive.parquet")
    assert set(archive["id"]) <= set(born.index)
    place = {name: number for number, name in enumerate(born.index)}
    for name, parents in born["parents"].items():
        assert all(place[parent] < place[name] for parent in parents)
    assert (born["parents"].map(len) == 0).any()


def test_every_object_has_a_mesh_with_its_volume(finished, load):
    objects = load("egad/objects.parquet")
    for row in objects.itertuples():
        mesh = trimesh.load_mesh(finished.results / f"egad/meshes/{row.label}.obj")
        assert mesh.is_watertight == row.watertight
        assert mesh.volume == pytest.approx(row.volume, rel=1e-6)
        assert mesh.extents.max() <= 0.1 * (1 + 2**-23)  # to the rounding of single precision
    meshes = {path.stem for path in (finished.results / "egad/meshes").glob("*.obj")}
    assert meshes == set(objects["label"])


def test_every_object_is_scaled_for_the_gripper(load):
    objects, scales = load("egad/objects.parquet"), load(f"egad/rescaled/{GRIPPER}/scales.parquet")
    assert sorted(scales["label"]) == sorted(objects["label"])
    opening = Settings().grippers[GRIPPER].opening
    assert (scales["after_1"] <= 0.8 * opening + 1e-9).all()
    assert (scales["factor"] <= 1).all()


def test_every_object_has_grasps_or_was_rejected(load):
    objects, grasps = load("egad/objects.parquet"), load(f"egad/grasps/{GRIPPER}.parquet")
    without = load(f"egad/grasps/{GRIPPER}.rejected.parquet")
    assert set(objects["id"]) == set(grasps["id"]) | set(without["id"])
    assert (grasps["width"] <= Settings().grippers[GRIPPER].opening).all()
    assert grasps.groupby("id").size().max() <= 10
    assert not grasps.duplicated(["id", "grasp"]).any()


def test_grasps_are_in_the_order_of_their_objects_and_numbers(load):
    grasps = load(f"egad/grasps/{GRIPPER}.parquet")
    rows = list(zip(grasps["label"], grasps["grasp"], strict=True))
    assert rows == sorted(rows)


def test_every_candidate_is_accounted_for(load):
    grasps = load(f"egad/grasps/{GRIPPER}.parquet")
    tally = load(f"egad/grasps/{GRIPPER}.sampling.parquet").set_index("id")
    assert set(tally.index) == set(load("egad/objects.parquet")["id"])
    causes = ["n_too_wide", "n_not_antipodal", "n_blocked", "n_too_close", "n_surplus", "n_grasps"]
    assert (tally[causes].sum(axis=1) == tally["n_candidates"]).all()
    rows = grasps.groupby("id").size().reindex(tally.index, fill_value=0)
    assert (rows == tally["n_grasps"]).all()
    assert (tally["n_wanted"] == 10).all()


def test_the_evaluation_set_is_printed_and_tried(finished, load):
    evalset = load("egad/eval49.parquet")
    assert 1 <= len(evalset) <= 9
    assert set(evalset["id"]) <= set(load("egad/objects.parquet")["id"])
    manifest = load(f"egad/print/{GRIPPER}/manifest.parquet")
    assert set(manifest["label"]) == set(evalset["label"])
    for name in manifest["file"]:
        assert (finished.results / f"egad/print/{GRIPPER}" / name).stat().st_size > 84
    trials = load(f"egad/trials/{GRIPPER}/{DETECTOR}.parquet")
    assert trials.groupby("label").size().to_dict() == dict.fromkeys(evalset["label"], 2)


def test_the_evaluation_set_is_made_ready_for_simulators(finished, load):
    folder = finished.results / "egad" / "bundle" / GRIPPER
    table = parquet.read(folder / "bundle.parquet", BUNDLE)
    rejected = parquet.read(folder / "rejected.parquet", REJECTED)
    assert set(table["id"]) | set(rejected["id"]) == set(load("egad/eval49.parquet")["id"])
    for label in table["label"]:
        assert (folder / label / f"{label}.urdf").exists()
    sums, noted = read_sums(folder / "SHA256SUMS")
    assert noted["stage"] == "bundle"
    for file, value in sums.items():
        assert hashlib.sha256(file.read_bytes()).hexdigest() == value


def test_the_comparison_is_drawn_again_and_said_on_the_terminal(copy, finished):
    drawn = (finished.results / "comparison.svg").read_bytes()
    (copy.results / "comparison.svg").unlink()
    said = copy.make("--cores", 1, "results/comparison.svg")
    assert "\npublished\nEGAD, 2020 " in said
    assert (copy.results / "comparison.svg").read_bytes() == drawn


def test_logs_and_benchmarks_of_every_job_are_kept(finished):
    for folder, ending in (("logs", "log"), ("benchmarks", "tsv")):
        made = list((finished.folder / folder).rglob(f"*.{ending}"))
        assert len(made) == sum(finished.planned("--forceall").values()) - 1  # `all` has none


def test_no_job_compiles_kernels(finished, copy):
    """All were compiled before the first job, and each job loads what it needs."""

    def said(checkout):
        logs = (checkout.folder / "logs").rglob("*.log")
        return "".join(path.read_text() for path in logs)

    assert "[cache] data saved to" not in said(finished)
    shutil.rmtree(copy.folder / "logs")
    part = f"results/egad/parts/grasps-{GRIPPER}-0.parquet"
    (copy.folder / part).unlink()
    copy.make("--cores", 1, part, EGAD_TESTS_STARTED="1", NUMBA_DEBUG_CACHE="1")
    assert "[cache] data loaded from" in said(copy)
    assert "[cache] data saved to" not in said(copy)


def test_a_second_run_does_nothing(finished):
    before = {path: path.stat().st_mtime_ns for path in finished.results.rglob("*")}
    assert "Nothing to be done" in finished.make("--cores", 2)
    assert before == {path: path.stat().st_mtime_ns for path in finished.results.rglob("*")}


def test_deleted_tables_are_rebuilt_on_one_core_byte_for_byte(copy):
    """Also where an interrupted write left something behind."""
    before = copy.bytes()
    deleted = ["egad/eval49.parquet", f"egad/grasps/{GRIPPER}.parquet", "comparison.parquet"]
    for path in deleted:
        (copy.results / path).unlink()
        (copy.results / path).with_name(f".{Path(path).name}.partial").write_bytes(b"half a table")
    copy.make("--cores", 1, *(f"results/{path}" for path in deleted))
    assert copy.bytes() == before


@pytest.mark.slow
def test_one_core_gives_the_same_bytes_as_two(clean, finished):
    clean.make("--cores", 1, EGAD_TESTS_STARTED="1")
    one, two = clean.bytes(), finished.bytes()
    assert set(one) == set(two)
    assert {path for path in one if _digest(one[path]) != _digest(two[path])} == set()


def _digest(data):
    return hashlib.sha256(data).hexdigest()


def test_every_gripper_is_a_target(copy):
    """All can be planned; the first that is no target of the test configuration is scaled for."""
    targets = {name: f"results/egad/rescaled/{name}/scales.parquet" for name in Settings().grippers}
    assert copy.planned(*targets.values()) == {"rescale": len(targets) - 1}
    other = next(name for name in targets if name != GRIPPER)
    copy.make("--cores", 1, targets[other])
    scales = parquet.read(copy.folder / targets[other], SCALES)
    assert set(scales["opening"]) == {Settings().grippers[other].opening}
    assert len(scales) == len(list((copy.results / "egad/meshes").glob("*.obj")))


@pytest.mark.slow
def test_more_epochs_keep_the_archives_of_the_earlier_ones(copy):
    before = copy.bytes()
    longer = copy.overlay(
        "longer.yaml", {"schedule": {"epochs": 3}, "evolution": {"evaluations": 120}}
    )
    copy.make("--cores", 2, "results/egad/archive.parquet", configs=["config/test.yaml", longer])
    after = copy.bytes()
    assert all(after[path] == before[path] for path in EPOCH_TABLES)
    archive = parquet.read(copy.results / "egad/archive.parquet", ARCHIVE)
    assert archive["epoch"].max() <= 2
    assert after["egad/epochs/epoch-2/archive.parquet"] != b""


@pytest.fixture
def own_meshes(clean):
    """A clean checkout with a folder of meshes, good and bad, and its configuration."""
    folder = clean.folder / "my meshes"
    folder.mkdir()
    box = trimesh.creation.box((40, 30, 20))
    box.export(folder / "box.obj")
    trimesh.creation.icosphere(subdivisions=2, radius=20).export(folder / "ball.stl")
    (folder / "notes.obj").write_text("This is not a mesh.\n")
    (folder / "empty.obj").write_text("")
    (folder / "nan.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    box.update_faces(box.face_normals[:, 2] < 0.5)
    box.export(folder / "open.ply")
    (folder / "cut.glb").write_bytes(b"glTF\x02\x00")
    dataset = {"source": "meshes", "folder": "my meshes", "units": "mm"}
    own = clean.overlay("own.yaml", {"datasets": {"own": dataset}, "targets": {"datasets": []}})
    return clean, ["config/test.yaml", own]


def test_a_folder_of_meshes_is_a_dataset_and_bad_ones_are_named(own_meshes):
    checkout, configs = own_meshes
    checkout.make("--cores", 2, "results/own/objects.parquet", configs=configs)
    objects = parquet.read(checkout.results / "own/objects.parquet", OBJECTS)
    objects = objects.set_index("label")
    assert {"ball", "box"} <= set(objects.index) <= {"ball", "box", "open"}
    assert objects.loc["box", "volume"] == pytest.approx(24e-6, rel=1e-6)
    rejected = parquet.read(checkout.results / "own/rejected.parquet", REJECTED)
    reasons = rejected.set_index("id")["reason"]
    assert {"notes", "empty", "nan", "cut"} <= set(reasons.index)
    assert set(reasons.index) | set(objects.index) == {
        *("ball", "box", "cut", "empty", "nan", "notes", "open")
    }
    assert reasons.str.len().gt(5).all()


@pytest.mark.slow
def test_a_run_that_was_killed_goes_on_to_the_same_bytes(clean, finished):
    second_epoch = clean.folder / "logs/egad/evolve/epoch-1-island-0.log"
    process = clean.start("--cores", 2)
    while not second_epoch.exists() and process.poll() is None:
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    first = clean.results / "egad/epochs/epoch-0/archive.parquet"
    kept = first.stat().st_mtime_ns
    assert not (clean.results / "egad/archive.parquet").exists()

    clean.make("--unlock")
    clean.make("--cores", 2, "results/egad/archive.parquet")
    assert first.stat().st_mtime_ns == kept
    after, expected = clean.bytes(), finished.bytes()
    for path in ["egad/archive.parquet", *EPOCH_TABLES]:
        assert after[path] == expected[path], path


@pytest.mark.slow
def test_everybody_gets_the_same_evaluation_set_from_the_released_objects(clean):
    table = "results/egad/eval49.parquet"
    clean.make("--cores", 2, table, configs=["config/released.yaml"])
    chosen = parquet.read(clean.folder / table, EVAL49)
    expected = pd.read_csv(evaluation_set())
    assert chosen[["label", "id"]].values.tolist() == expected.values.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("cells", [10, 26])
def test_another_grid_and_axes_of_ones_own_go_all_the_way(clean, cells):
    measures = "def area(mesh): return mesh.area\ndef volume(mesh): return mesh.volume\n"
    (clean.folder / "mine.py").write_text(measures)
    own = {
        "space": {
            "cells": cells,
            "complexity_range": [0, 0.06],
            "graspability_range": [0.0001, 0.001],
        },
        "measures": {"complexity": "mine.py:area", "graspability": "mine.py:volume"},
        "symmetry": {"mirror": ["y"]},
    }
    clean.make("--cores", 2, configs=["config/test.yaml", clean.overlay("own.yaml", own)])
    objects = parquet.read(clean.results / "egad/objects.parquet", OBJECTS)
    np.testing.assert_allclose(objects["complexity"], objects["area"], rtol=1e-9)
    np.testing.assert_allclose(objects["graspability"], objects["volume"], rtol=1e-6)
    last = objects.loc[objects["volume"].idxmin(), "label"]
    assert last[0] == chr(ord("A") + cells - 1)
    report = (clean.results / "report.html").read_text()
    assert "area: low → high" in report
    assert "volume: high → low" in report


def test_an_archive_is_a_dataset(copy):
    """The archive of a run starts another one: the same objects, labels and measures.

    In one job instead of two, which changes no result.
    """
    given = {"source": "archive", "archive": "results/egad/archive.parquet"}
    again = copy.overlay("again.yaml", {"shards": 1, "datasets": {"again": given}})
    copy.make("--cores", 2, "results/again/objects.parquet", configs=["config/test.yaml", again])
    ours, theirs = (
        parquet.read(copy.results / name / "objects.parquet", OBJECTS) for name in ("again", "egad")
    )
    pd.testing.assert_frame_equal(ours, theirs)
