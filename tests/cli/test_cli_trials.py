"""`egad trials`: what people do with results."""

import pandas as pd
import pytest
from commands import egad
from partial_tables import write_rows

from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import EVAL49, RESULTS, TRIALS


def trials(*arguments):
    return egad("trials", *arguments)


@pytest.fixture
def filled(tmp_path):
    """A template that was filled in: everything worked for `good`, half of it for `fair`."""
    for name, every in (("good", 1), ("fair", 2)):
        path = tmp_path / f"{name}.csv"
        assert trials("template", "--out", path, "--detector", name).returncode == 0
        frame = pd.read_csv(path)
        frame["success"] = [int(row % every == 0) for row in range(len(frame))]
        frame.to_csv(path, index=False)
    return tmp_path


def test_a_template_is_filled_in_imported_and_compared(filled):
    page, table = filled / "good.html", filled / "good.parquet"
    result = trials("report", filled / "good.csv", "--out", page, "--out", table)
    assert result.returncode == 0, result.stderr
    assert "good" in result.stdout
    assert "100.0" in result.stdout
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert len(parquet.read(table, RESULTS)) == 980
    compared = filled / "compared.html"
    result = trials("compare", table, filled / "fair.csv", "--out", compared)
    assert result.returncode == 0, result.stderr
    assert "good vs fair" in result.stdout
    assert "50.0" in result.stdout
    assert "good vs. fair" in compared.read_text()


def test_objects_under_their_own_names_are_reported_and_compared(filled):
    for name in ("good", "fair"):
        frame = pd.read_csv(filled / f"{name}.csv").query("label in ['A0', 'G6', 'C4']")
        frame.assign(label="mug " + frame["label"]).to_csv(filled / f"{name}.csv", index=False)
    result = trials("report", filled / "good.csv", "--out", filled / "good.html")
    assert result.returncode == 0, result.stderr
    result = trials("compare", filled / "good.csv", filled / "fair.csv", "--out", filled / "c.html")
    assert result.returncode == 0, result.stderr
    assert "good vs. fair" in (filled / "c.html").read_text()


def test_objects_that_are_not_in_the_set_are_left_out_and_named(filled):
    write_rows(EVAL49, [{"label": "A0"}, {"label": "B3"}], filled / "eval49.parquet")
    few = pd.read_csv(filled / "good.csv").query("label in ['A0', 'G6', 'C4']")
    few.to_csv(filled / "few.csv", index=False)
    given = ["report", filled / "few.csv", "--eval", filled / "eval49.parquet"]
    result = trials(*given, "--out", filled / "few.html", "--out", filled / "few.parquet")
    assert result.returncode == 0, result.stderr
    assert "good: not in --eval, left out: C4, G6" in result.stderr
    assert set(parquet.read(filled / "few.parquet", RESULTS)["label"]) == {"A0"}
    few.query("label == 'G6'").to_csv(filled / "few.csv", index=False)
    result = trials(*given, "--out", filled / "few.html")
    assert result.returncode == 1
    assert "good has no attempt at an object of --eval" in result.stderr


def test_tables_of_two_evaluation_sets_are_refused(tmp_path):
    """What the simulation writes keeps the object's id on its way into a comparison."""
    for name, number in (("one", 1), ("other", 1), ("another", 2)):
        rows = [{"label": label, "id": f"{label}-{number}"} for label in ("A0", "B3")]
        write_rows(TRIALS, rows, tmp_path / f"{name}.parquet")
    same = trials("compare", tmp_path / "one.parquet", tmp_path / "other.parquet")
    assert same.returncode == 0, same.stderr
    result = trials("compare", tmp_path / "one.parquet", tmp_path / "another.parquet")
    assert result.returncode == 1
    assert "A0 is the object A0-1 in one table and A0-2 in the other" in result.stderr
    assert "Traceback" not in result.stderr


def test_a_comparison_says_that_conditions_differ(tmp_path):
    for name in ("none", "typical"):
        rows = [{"label": label, "errors": name, "engine": "mujoco"} for label in ("A0", "B3")]
        write_rows(TRIALS, rows, tmp_path / f"{name}.parquet")
    (tmp_path / "alike").mkdir()
    (tmp_path / "alike/also.parquet").write_bytes((tmp_path / "none.parquet").read_bytes())
    result = trials("compare", tmp_path / "none.parquet", tmp_path / "typical.parquet")
    assert "mujoco, errors: typical" in result.stdout
    assert "Not all were simulated in the same way" in result.stderr
    result = trials("compare", tmp_path / "none.parquet", tmp_path / "alike/also.parquet")
    assert "Not all" not in result.stderr


def cleared_table(path, won, **changes):
    """Two rounds with one object each."""
    row = {"scene": "single", "noise": "none", "objects": "a", "engine": "mujoco", "n_objects": 1}
    ends = ["success" if each else "missed" for each in won]
    rounds = enumerate(zip(won, ends, strict=True))
    rows = [row | {"round": n, "success": ok, "outcome": end} | changes for n, (ok, end) in rounds]
    write_rows(CLUTTER, rows, path)
    return path


def test_cleared_tables_are_compared_and_make_a_page(tmp_path):
    good = cleared_table(tmp_path / "good.parquet", (True, True))
    fair = cleared_table(tmp_path / "fair.parquet", (True, False), engine="pybullet")
    page = tmp_path / "page.html"
    result = trials("compare", good, fair, "--out", page)
    assert result.returncode == 0, result.stderr
    words = result.stdout.split()
    assert {"good", "fair", "mujoco", "pybullet", "100.0", "50.0"} <= set(words)
    assert "good vs fair" in result.stdout
    text = page.read_text()
    assert text.startswith("<!DOCTYPE html>")
    assert "good vs fair" in text
    assert "fair: simulated in pybullet" in text


def test_cleared_tables_of_different_rules_say_so(tmp_path):
    ours = cleared_table(tmp_path / "ours.parquet", (True, True), protocol="egad")
    same = cleared_table(tmp_path / "same.parquet", (True, False), protocol="egad")
    theirs = cleared_table(tmp_path / "theirs.parquet", (True, False), protocol="giga")
    odd = cleared_table(tmp_path / "odd.parquet", (True, False), protocol="custom")
    other = cleared_table(tmp_path / "other.parquet", (True, False), protocol="custom")
    page = tmp_path / "page.html"
    result = trials("compare", ours, same, theirs, "--out", page)
    said = "The rules are different (egad: ours, same; giga: theirs)"
    assert said in result.stdout
    assert said in page.read_text()
    assert "ours vs theirs" in result.stdout
    assert "The rules" not in trials("compare", ours, same).stdout
    assert "The rules may be different (custom: odd, other)" in trials("compare", odd, other).stdout
    off = cleared_table(tmp_path / "off.parquet", (True, False), protocol="egad", errors="typical")
    said = "The rules are different (egad: ours; egad, errors: typical: off)"
    assert said in trials("compare", ours, off).stdout


def test_cleared_tables_and_trials_are_compared_apart(tmp_path, filled):
    good = cleared_table(tmp_path / "cleared.parquet", (True,))
    result = trials("compare", filled / "good.csv", good)
    assert result.returncode == 1
    assert "cleared.parquet is of cleared tables" in result.stderr
    assert "at least two detectors" in trials("compare", good).stderr


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["template", "--out", "good.csv"], "exists and may already be filled in"),
        (["report", "good.csv", "--out", "page.pdf"], "must end in .html or .parquet or .csv"),
        (["compare", "good.csv", "good.csv", "good.csv"], "two tables have the same detector"),
        (["compare", "good.csv", "broken.parquet"], "not a readable Parquet file"),
    ],
)
def test_mistakes_are_one_sentence(filled, monkeypatch, arguments, sentence):
    monkeypatch.chdir(filled)
    (filled / "broken.parquet").write_text("PAR1")
    result = trials(*arguments)
    assert result.returncode == 1
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr
