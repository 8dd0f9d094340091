"""`egad trials plan`, `validate` and `compare --sequential`: what they print, and mistakes."""

import numpy as np
import pandas as pd
import pytest
from commands import egad
from partial_tables import write_rows

from egad.tables.evaluation import TRIALS

LABELS = [f"{row}{column}" for row in "ABCD" for column in range(5)]


def attempts(rates, count=10, seed=0, *, rounds=False):
    """Attempts at objects with these rates."""
    rng = np.random.default_rng(seed)
    numbers = [(label, n) for label in rates for n in range(count)]
    numbers = sorted(numbers, key=lambda each: (each[1], each[0])) if rounds else numbers
    rows = [(label, n, int(rng.random() < rates[label])) for label, n in numbers]
    return pd.DataFrame(rows, columns=["label", "attempt", "success"])


@pytest.fixture
def tables(tmp_path, monkeypatch):
    """Three detectors in simulation, in Parquet, and on a robot, in one CSV file."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    real = []
    for number, name in enumerate(("good", "fair", "poor")):
        rates = dict(
            zip(LABELS, np.clip(rng.normal(0.8 - 0.2 * number, 0.2, 20), 0, 1), strict=True)
        )
        table = attempts(rates, 10, number).assign(engine="mujoco", outcome="other")
        write_rows(TRIALS, table.assign(success=table["success"] > 0), tmp_path / f"{name}.parquet")
        few = {label: 0.8 * rate for label, rate in rates.items() if label[0] in "AB"}
        real.append(attempts(few, 10, 10 + number, rounds=True).assign(detector=name))
    pd.concat(real).to_csv("real.csv", index=False)
    return tmp_path


def lines(result):
    assert result.returncode == 0, result.stderr
    return [line.split() for line in result.stdout.splitlines()]


@pytest.mark.usefixtures("tables")
def test_simulation_is_validated_by_objects_and_by_detectors():
    result = egad("trials", "validate", "good.parquet", "fair.parquet", "poor.parquet", "real.csv")
    found = lines(result)
    heads = [number for number, line in enumerate(found) if line and line[0] in ("over", "real")]
    assert [found[number][1] for number in heads] == ["objects", "detectors", "success"]
    assert [line[:2] for line in found[1:4]] == [["good", "10"], ["fair", "10"], ["poor", "10"]]
    assert found[heads[1] + 1][:2] == ["all", "3"]
    assert "Pearson at most" in result.stdout.splitlines()[0]
    assert [line[:3] for line in found[heads[2] + 1 :]] == [
        [name, "10", "10"] for name in ("good", "fair", "poor")
    ]
    assert "3 detectors are too few for correlations to say much" in result.stderr


@pytest.mark.usefixtures("tables")
def test_published_rates_of_objects_are_enough():
    whole = pd.read_csv("real.csv")
    good = whole[whole["detector"] == "good"].groupby("label")["success"].agg(["sum", "size"])
    rate = (100 * good["sum"] / good["size"]).map("{:g} %".format)
    pd.DataFrame({"success_rate": rate}).to_csv("paper.csv")
    counts = good.rename(columns={"sum": "successes", "size": "attempts"})
    counts.to_csv("counts.csv")
    printed = [
        lines(egad("trials", "validate", "good.parquet", name))
        for name in ("paper.csv", "counts.csv")
    ]
    whole[whole["detector"] == "good"].to_csv("good.csv", index=False)
    assert printed[1] == lines(egad("trials", "validate", "good.parquet", "good.csv"))
    without_limit = [[cell for cell in line if cell != "-"] for line in printed[0]]
    assert without_limit[1][:4] == printed[1][1][:4]
    assert "-" in printed[0][1]  # how many attempts is not known


@pytest.mark.usefixtures("tables")
def test_looking_early_is_a_table_of_its_own():
    result = egad("trials", "compare", "real.csv", "--sequential")
    printed = lines(result)
    (row,) = [
        line for line in printed if line[:4] == ["good", "vs", "poor", "100"] and "after" in line
    ]
    assert row[-4:-2] == ["good,", "after"]
    assert not result.stderr
    plain = egad("trials", "compare", "real.csv")
    assert "needed" not in plain.stdout


@pytest.mark.usefixtures("tables")
def test_attempts_at_one_object_after_another_are_warned_of():
    frame = pd.read_csv("real.csv").sort_values(["detector", "label", "attempt"])
    frame.to_csv("sorted.csv", index=False)
    result = egad("trials", "compare", "sorted.csv", "--sequential")
    assert result.returncode == 0
    assert "good: up to 10 attempts at one object follow each other" in result.stderr
    simulated = egad("trials", "compare", "good.parquet", "poor.parquet", "--sequential")
    assert "poor.parquet" not in simulated.stderr
    assert not simulated.stderr
    assert "good, after" in simulated.stdout


@pytest.mark.usefixtures("tables")
def test_attempts_are_planned():
    given = ["--difference", 30, "--spread", 20, "--correlation", 0.9, "--most", 30]
    head, _, first, second = lines(egad("trials", "plan", *given, "--objects", 5, "--objects", 15))
    assert " ".join(head).startswith("Success 60 %, objects vary by 20 points")
    assert first[:4] == ["5", "-", "-", "0"]
    assert second[0] == "15"
    assert int(second[1]) * 15 == int(second[2])
    assert int(second[3]) >= 80
    assert int(second[5]) < int(second[4])


@pytest.mark.usefixtures("tables")
def test_attempts_are_planned_from_results():
    given = ["--difference", 30, "--most", 5, "--objects", 20]
    several = egad("trials", "plan", *given, "--from", "real.csv", "--rate", 55)
    assert lines(several)[0][:3] == ["Success", "55", "%,"]
    one = egad("trials", "plan", *given, "--from", "good.parquet").stdout
    assert "correlation of both detectors 0.70" in one
    assert "correlation of both detectors 0.70" not in several.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["validate", "good.parquet"], "at least two files"),
        (["validate", "good.parquet", "fair.parquet", "x.csv"], "no detector is on both sides: si"),
        (["validate", "good.parquet", "y.csv"], "no object is on both sides: simulated A0, A1, "),
        (["validate", "good.parquet", "z.csv"], "line 2: success_rate is '85'; allowed: 0 to 1"),
        (["plan", "--difference", "0"], "the difference is 0 percentage points; allowed"),
        (["plan", "--from", "once.csv"], "at least two objects with two attempts each"),
    ],
)
def test_mistakes_with_few_trials_are_one_sentence(tables, arguments, sentence):
    (tables / "x.csv").write_text("label,success_rate,detector\nA0,0.5,a\nA0,0.5,b\n")
    (tables / "y.csv").write_text("label,success_rate\nmug,0.5\n")
    (tables / "z.csv").write_text("label,success_rate\nA0,85\n")
    (tables / "once.csv").write_text("label,attempt,success\nA0,0,1\nA1,0,0\n")
    result = egad("trials", *arguments)
    assert result.returncode == 1
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr
    (line,) = [line for line in result.stderr.splitlines() if not line.startswith("simulating")]
    assert line.startswith("egad: ")
