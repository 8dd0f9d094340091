"""The tables and figures of README.md, against counts of the attempts."""

import re
import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from partial_tables import write_rows
from scipy import stats

from egad.errors import UserError
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.grasping import SCALES
from egad.tables.images import IMAGES

STUDY = Path(__file__).parent


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    """Attempts of two sets of two networks and of a detector, and the folder of their tables."""
    rng = np.random.default_rng(5)
    names = [("few", 0), ("few", 1), ("many", 0), ("many", 1), ("", 0)]
    labels = [f"{row}{column}" for row in "ABG" for column in range(3)]
    rows = [
        {"test": "own", "noise": "none", "training_set": name, "seed": seed, "id": label}
        | {"label": label, "attempt": attempt, "initial_x": attempt / 100}
        | {"detector": f"{name or 'random'}-{seed}"}
        | {"outcome": "success" if rng.random() < 0.7 - 0.1 * seed else "missed"}
        for name, seed in names
        for label in labels
        for attempt in range(4)
    ]
    table = pd.DataFrame(rows).assign(quality=0.5)
    table = table.assign(success=table["outcome"] == "success")
    folder = tmp_path_factory.mktemp("tried")
    keep_trials(table, folder)
    return folder, table


def keep_trials(table, folder):
    """The tables of the trials, one of each network and detector."""
    for name, rows in table.groupby("detector"):
        kept = rows[rows.columns.intersection(TRIALS.names)].drop(columns="seed")
        write_rows(TRIALS, kept, folder / f"trials/own/none/{name}.parquet")


@pytest.fixture
def pair(tmp_path):
    """A study of two sets of two networks, to be compared."""
    values = {
        "egad": {
            "detectors": {"random-0": {"detector": "random"}},
            "datasets": {"own": {"source": "primitives", "objects": 9}},
            "targets": {"datasets": []},
        },
        "training_sets": {name: {"dataset": "own"} for name in ("few", "many")},
        "sets": ["few", "many"],
        "seeds": 2,
        "tests": ["own"],
        "noise": ["none"],
        "references": ["labels", "random-0"],
        "comparisons": [["few", "many"]],
        "object_curve": ["few", "many"],
    }
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump(values))
    return path


def tables(text):
    """Printed tables by their first heading: cells by the first one of their line."""
    found = {}
    for block in text.strip().split("\n\n"):
        head, _, *lines = [
            [cell.strip() for cell in line.split("|")] for line in block.splitlines()
        ]
        found[head[1]] = {line[1]: line[2:-1] for line in lines}
    return found


@pytest.fixture(scope="module")
def study():
    return runpy.run_path(str(STUDY / "docs_tables.py"))


def test_tables_of_the_study_are_counts_of_its_attempts(study, tried, pair, capsys):
    folder, table = tried
    study["main"](folder, pair, folder)
    said = tables(capsys.readouterr().out)
    few = table[table["training_set"] == "few"]
    rate = few["success"].mean()
    count, mean = said["success"]["`few`"]
    assert count == "2"
    assert mean.startswith(f"{100 * rate:.0f} (")
    each = few.groupby("seed")["success"].mean()
    deviations = said["networks on own, single, none, success"]
    assert deviations["`few`"][0].startswith(f"{100 * each.std():.1f} (")
    assert set(deviations) == {"`few`", "`many`", "all"}
    gain = rate - table[table["training_set"] == "many"]["success"].mean()
    assert said["pair"]["`few` - `many`"][1].startswith(f"{100 * gain:.1f} (")
    assert "own, no noise" in (folder / "training.svg").read_text()


def test_a_set_is_compared_with_each_other_one(study, tried, pair, capsys):
    """With two sets, the interval is that of Student's test with equal variances."""
    folder, table = tried
    study["main"](folder, pair, folder, "few")
    said = tables(capsys.readouterr().out)["success, `few` minus"]
    few, many = (
        table[table["training_set"] == name].groupby("seed")["success"].mean()
        for name in ("few", "many")
    )
    found = stats.ttest_ind(few, many).confidence_interval()
    gain = f"{100 * (few.mean() - many.mean()):.1f}"
    assert said == {"`many`": [f"{gain} ({100 * found.low:.1f} to {100 * found.high:.1f})"]}
    with pytest.raises(UserError, match=r"no set 'fewer' was tested; these were: few, many$"):
        study["main"](folder, pair, folder, "fewer")


def test_parts_of_the_study_add_up(study, tried, pair, tmp_path, capsys):
    """A network that is tested again replaces the earlier one."""
    folder, table = tried
    whole, docs = tmp_path / "whole", tmp_path / "docs"
    whole.mkdir()
    docs.mkdir()
    study["main"](folder, pair, whole)
    expected = tables(capsys.readouterr().out)
    few, last = table["training_set"] == "few", table["detector"] == "many-1"
    worse = table[few].assign(success=False, outcome="missed")
    said = []
    for number, part in enumerate([table[~few & ~last], worse, table[last], table[few]]):
        keep_trials(part, tmp_path / str(number))
        study["main"](tmp_path / str(number), pair, docs)
        said.append(tables(capsys.readouterr().out))
    assert ["pair" in each for each in said] == [False, False, True, True]
    assert ["`few`" in each["success"] for each in said] == [False, False, True, True]
    assert said[2]["pair"] != expected["pair"]
    assert said[3] == expected


def test_a_learning_curve_is_drawn_once_the_images_of_its_sets_are_there(
    study, tried, pair, tmp_path
):
    folder, _ = tried
    docs = tmp_path / "docs"
    docs.mkdir()
    (tmp_path / "trials").symlink_to(folder / "trials")
    for name, count in [("few", 3), ("many", 20)]:
        study["main"](tmp_path, pair, docs)
        assert not (docs / "training-objects.svg").exists()
        images = tmp_path / "images" / name
        rows = [{"objects": [f"o{number}"], "split": "train"} for number in range(count)]
        write_rows(IMAGES, rows, images / "images-0.parquet", {"shards": 1})
        (images / "card.md").touch()
    study["main"](tmp_path, pair, docs)
    said = re.findall(">([^<>]+)</text>", (docs / "training-objects.svg").read_text())
    assert {"3", "20", "training objects"} <= {each.strip() for each in said}


def test_clutter_is_kept_with_the_rest(study, tried, pair, tmp_path, capsys):
    _, table = tried
    keep_trials(table, tmp_path)
    for seed in range(2):
        won = {"outcome": "success", "success": True}
        lost = {"outcome": "missed", "success": False}
        rows = [
            {"scene": "pile", "noise": "none", "round": number, "n_objects": 4, "seed": "ab"} | end
            for number in range(2)
            for end in [won] * (1 + seed) + [lost]
        ]
        write_rows(CLUTTER, rows, tmp_path / f"clutter/own/few-{seed}.parquet")
    for _ in range(2):
        study["main"](tmp_path, pair, tmp_path)
        said = tables(capsys.readouterr().out)
        cleared = pd.Series([1 / 4, 2 / 4])
        found = said["networks on own, pile, none, cleared"]["`few`"][0]
        assert found.startswith(f"{100 * cleared.std():.1f} (")
    assert len(pd.read_parquet(tmp_path / "training_clutter.parquet")) == 10


def test_a_part_with_other_drops_is_refused(study, tried, pair, tmp_path):
    _, table = tried
    few, many = (table[table["training_set"] == name] for name in ("few", "many"))
    keep_trials(many, tmp_path / "0")
    keep_trials(few.assign(initial_x=0.07), tmp_path / "1")
    study["main"](tmp_path / "0", pair, tmp_path)
    before = (tmp_path / "training.parquet").read_bytes()
    with pytest.raises(UserError, match="different drop"):
        study["main"](tmp_path / "1", pair, tmp_path)
    assert (tmp_path / "training.parquet").read_bytes() == before


def test_rounding_makes_no_other_drop(study, tried, pair, tmp_path):
    """Of 200 drops, some are equal but for the last bits, and others come to rest elsewhere."""
    _, table = tried
    rows = pd.concat([table.assign(attempt=table["attempt"] + 4 * n) for n in range(6)])
    few, many = (rows[rows["training_set"] == name] for name in ("few", "many"))
    keep_trials(many.assign(initial_x=0.03), tmp_path / "0")
    study["main"](tmp_path / "0", pair, tmp_path)
    moved = few.assign(initial_x=0.03 + np.where(few["attempt"] < 9, 1e-16, 0.0))
    for odd, number in [(1, 1), (9, 2)]:
        first = (few["label"] == "A0") & (few["attempt"] < odd)
        keep_trials(
            moved.assign(initial_x=moved["initial_x"] + 0.02 * first), tmp_path / str(number)
        )
    study["main"](tmp_path / "1", pair, tmp_path)
    assert set(pd.read_parquet(tmp_path / "training.parquet")["training_set"]) == {"few", "many"}
    with pytest.raises(UserError, match="4% of the attempts at own"):
        study["main"](tmp_path / "2", pair, tmp_path)


def test_limits_of_a_set_are_counts_of_its_attempts(study, tried, pair, tmp_path, capsys):
    folder, table = tried
    few = table[table["training_set"] == "few"]
    reached = few["label"].isin(["A0", "B1"]) & (few["attempt"] < 3)
    outcome = np.where(reached, "success", "no_grasp")
    best = few[few["seed"] == 0].assign(training_set="", detector="labels", success=reached)
    keep_trials(best.assign(outcome=outcome[: len(best)]), tmp_path)
    study["main"](folder, pair, tmp_path)
    study["main"](tmp_path, pair, tmp_path)
    labels = sorted(set(table["label"]))
    objects = [{"label": label, "object_label": label} for label in labels]
    write_rows(EVAL49, objects, tmp_path / "own/eval49.parquet")
    scales = [
        {
            "label": label,
            "after_1": 0.01 if label == "A0" else 0.03,
            "after_2": 0.05,
            "after_3": 0.1,
        }
        for label in labels
    ]
    write_rows(SCALES, scales, tmp_path / "own/rescaled/egad_75mm/scales.parquet")
    capsys.readouterr()
    runpy.run_path(str(STUDY / "limits.py"))["main"](tmp_path, pair, tmp_path)
    blocks = [tables(each)["own, no noise"] for each in capsys.readouterr().out.split("\n\n")]
    outcomes, parts, objects, reach = blocks
    rate = few["success"].mean()
    assert outcomes["`few`"] == [f"{100 * rate:.1f}", f"{100 - 100 * rate:.1f}", "0.0"]
    assert list(parts) == ["A", "B", "G", "0", "1", "2", "to 20 mm", "20 to 45 mm"]
    for part, own in [("B", ["B0", "B1", "B2"]), ("1", ["A1", "B1", "G1"]), ("to 20 mm", ["A0"])]:
        mean = few[few["label"].isin(own)]["success"].mean()
        assert parts[part][0] == f"{100 * mean:.0f}"
    failures = (~few["success"]).groupby(few["label"]).sum()
    first, second, *_ = list(objects)
    assert failures[first] == failures.max()
    assert objects["A0"][0] == "10 x 50 x 100"
    assert float(objects[second][1]) == pytest.approx(
        100 * (failures[first] + failures[second]) / failures.sum(), abs=0.5
    )
    assert objects[first][2] == f"{100 - 100 * failures[first] / 8:.0f}"
    for head, chosen in [("labelled grasp", reached), ("none", ~reached)]:
        share, success, *_ = reach[head]
        assert share == f"{100 * chosen.mean():.0f}"
        assert success == f"{100 * few[chosen]['success'].mean():.0f}"
    share = few[few["label"] == "A0"]["success"].mean()
    assert f">{100 * share:.0f}</text>" in (tmp_path / "training-labels.svg").read_text()
