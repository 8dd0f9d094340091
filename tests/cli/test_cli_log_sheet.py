"""`egad log-sheet`: from a dataset to a page, and mistakes on the way."""

import pandas as pd
import pytest
import trimesh
from commands import egad
from partial_tables import write_rows

from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS


@pytest.fixture
def dataset(tmp_path):
    """The folder of a run with two objects in its evaluation set."""
    folder = tmp_path / "run"
    (folder / "meshes").mkdir(parents=True)
    names = {"1": "M14_3", "2": "E08_0", "3": "A00_0"}
    objects = [{"id": name, "label": label} for name, label in names.items()]
    write_rows(OBJECTS, objects, folder / "objects.parquet")
    chosen = [("A0", "2", "E08_0"), ("B3", "1", "M14_3")]
    rows = pd.DataFrame(chosen, columns=["label", "id", "object_label"])
    write_rows(EVAL49, rows, folder / "eval49.parquet")
    for label in names.values():
        trimesh.creation.box((0.03, 0.04, 0.05)).export(folder / "meshes" / f"{label}.obj")
    return folder


def log_sheet(dataset, *arguments, detectors="mine, theirs"):
    return egad("log-sheet", dataset, "--detectors", detectors, *arguments)


def test_a_dataset_makes_a_page_and_an_order(dataset, tmp_path):
    page, order = tmp_path / "log.html", tmp_path / "order.csv"
    done = log_sheet(dataset, "--attempts", 3, "--blind", "--out", page, "--out", order)
    assert done.returncode == 0, done.stderr
    assert "12 attempts at 2 objects" in done.stdout
    table = pd.read_csv(order, dtype=str, keep_default_na=False)
    assert set(zip(table["label"], table["id"], strict=True)) == {("A0", "2"), ("B3", "1")}
    assert set(table["detector"]) == {"mine", "theirs"}
    assert page.read_text().count("<figure>") == 2
    table["success"] = "1"
    table.to_csv(tmp_path / "filled.csv", index=False)
    done = egad("trials", "report", tmp_path / "filled.csv", "--out", tmp_path / "report.html")
    assert done.returncode == 0, done.stderr
    assert "100.0" in done.stdout


def test_the_released_objects_have_an_evaluation_set(tmp_path):
    out = tmp_path / "log.html"
    done = log_sheet("evaluation-set", "--objects", "C4", "--attempts", 1, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "2 attempts at 1 objects" in done.stdout
    assert '"label": "C4"' in out.read_text()
    assert "suction cup" not in out.read_text()
    one = ("--objects", "C4", "--attempts", 1, "--out", out, "--gripper", "cup_30mm")
    assert log_sheet("evaluation-set", *one).returncode == 0
    assert "the suction cup did not seal" in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--objects", "A0,B4"], "--objects: 'B4' is not known in the evaluation set; did you"),
        (["--objects", " ,"], "--objects names no object"),
        (["--out", "log.pdf"], "must end in .html or .csv"),
        (["--out", "filled.csv"], "exists and may already be filled in"),
    ],
)
def test_mistakes_of_a_sheet_are_one_sentence(dataset, monkeypatch, arguments, sentence):
    monkeypatch.chdir(dataset)
    (dataset / "filled.csv").write_text("")
    done = log_sheet(dataset, *arguments)
    assert done.returncode == 1
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr


def test_other_mistakes_are_told_too(dataset, tmp_path):
    assert "names twice" not in log_sheet(dataset, "--out", tmp_path / "log.html").stderr
    assert "mine is named twice" in log_sheet(dataset, detectors="mine,mine").stderr
    done = log_sheet(tmp_path / "nowhere")
    assert done.returncode == 1
    assert "nowhere/eval49.parquet is missing; make it with: snakemake" in done.stderr
