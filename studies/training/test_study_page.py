"""The page about training sets, from made-up tables."""

import re

import numpy as np
import pandas as pd
import pytest
from network_statistics import difference
from study import TrainingSet, page_settings, study_of
from study_charts import Row
from study_page import (
    Images,
    Results,
    Training,
    describe,
    learning_curves,
    object_sides,
    page,
)
from study_tables import CLEARED, COMPARED
from svg_text import texts

from egad.tables import parquet
from egad.tables.training import HISTORY

CONFIG = {
    "egad": {
        "datasets": {
            "egad": {"source": "evolved"},
            "own": {"source": "meshes", "folder": ".", "units": "m"},
        }
    },
    "sets": ["simple", "own", "both", "given"],
    "seeds": 2,
    "tests": ["egad", "own"],
    "noise": ["none", "stereo"],
    "clutter": ["pile"],
    "references": ["random"],
    "comparisons": [["simple", "own"], ["simple", "random"]],
    "object_curve": ["own", "simple", "both"],
    "training_sets": {
        "given": {"weights": "<given>.pt"},
        "own": {"dataset": "own", "render": {"hold_out": False}},
        "simple": {"dataset": "egad"},
        "both": {"images": ["simple", "own"], "seeds": 3},
    },
}
RATES = {"simple": 0.9, "own": 0.6, "both": 0.7, "given": 0.3, "": 0.1}
LABELS = ["A0", "A1", "B0", "C2"]
WIDTHS = {"A0": 0.01, "A1": 0.02, "B0": 0.03, "C2": 0.06}


def tried(test, noise, name, seed, detector):
    rng = np.random.default_rng([len(test), len(noise), len(name), seed])
    rows = [
        (label, f"{label}", n, bool(won), f"{n}")
        for label in LABELS
        for n, won in enumerate(rng.random(10) < RATES[name])
    ]
    table = pd.DataFrame(rows, columns=["label", "id", "attempt", "success", "initial_pose"])
    table = table.assign(test=test, noise=noise, training_set=name, seed=seed, quality=0.5)
    outcome = np.where(table["success"], "success", "collided")
    table = table.assign(outcome=outcome, detector=detector, engine="mujoco")
    return table.assign(errors="none", contact="collided")[COMPARED.names]


def cleared(test, name, seed, detector):
    """One round, of which every second attempt succeeds."""
    rows = [{"round": 0, "attempt": n, "n_objects": 4, "success": n % 2 == 0} for n in range(4)]
    table = pd.DataFrame(rows).assign(test=test, training_set=name, seed=seed, detector=detector)
    table = table.assign(scene="pile", noise="none", objects="a b c d", factors="1 1 1 1")
    table["outcome"] = np.where(table["success"], "success", "collided")
    return table.reindex(columns=CLEARED.names)


def history(seed):
    numbers = {name: np.linspace(0.5, 0.1 + 0.01 * seed, 3) for name in HISTORY.names}
    return pd.DataFrame(numbers | {"epoch": [0, 1, 2], "images": [8, 16, 24]})


def results(config=CONFIG):
    settings = page_settings(study_of(config))
    asked = settings.plan
    found = asked.networks
    names = [(each.training_set, each.seed, each.name) for each in found] + [("", 0, "random")]
    score = {"n_correct": 6, "n_images": 8, "ci_low": 0.3, "ci_high": 0.9}
    trained = [each for each in found if each.training_set != "given"]
    objects = {
        "simple": {("egad", "A0")},
        "own": {("own", "A0"), ("own", "A1")},
        "both": {("egad", "A0"), ("own", "A0"), ("own", "A1")},
    }
    by_key = dict(sorted(asked.training_sets.items()))  # as the workflow hands them over
    by_key = asked.model_copy(update={"training_sets": by_key})
    tables = [cleared(test, *name) for test in asked.tests for name in names if asked.clutter]
    return Results(
        settings=settings.model_copy(update={"plan": by_key}),
        trials=pd.concat(
            tried(test, noise, *name)
            for test in asked.tests
            for noise in asked.noise
            for name in names
        ),
        cleared=pd.concat(tables) if tables else parquet.empty(CLEARED),
        widths=dict.fromkeys(asked.tests, WIDTHS),
        images={
            each.training_set: Images(frozenset(objects[each.training_set]), 44) for each in trained
        },
        trainings={each: Training(history(each.seed), score) for each in trained},
    )


@pytest.fixture(scope="module")
def text():
    return page(results())


def rows(text, heading):
    """Cells of the first table after some text, a list a row."""
    table = text.partition(heading)[2].partition("<tbody>")[2].partition("</tbody>")[0]
    lines = re.findall(r"<tr.*?</tr>", table, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line, flags=re.DOTALL) for line in lines]
    return [[plain(cell) for cell in line] for line in cells]


def plain(cell):
    return re.sub(r"\s+", " ", cell.replace("\N{NO-BREAK SPACE}", " ")).strip()


def percent(value):
    return f"{100 * value:.1f} %".replace("-", "\N{MINUS SIGN}")


def rate(test, noise, name, seed=0):
    return tried(test, noise, name, seed, "")["success"].mean()


def test_the_page_needs_no_other_file_and_is_the_same_every_time(text):
    assert text == page(results())
    assert text.startswith("<!DOCTYPE html>")
    sources = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert sources
    assert all(source.startswith("data:image/svg+xml") for source in sources)
    assert "nan" not in re.sub(r'src="[^"]*"', "", text)


def test_the_sets_are_told_in_their_order(text):
    found = rows(text, "<h2>Training sets</h2>")
    assert [line[0] for line in found] == ["simple", "own", "both", "given"]
    assert found[1][1:] == [
        "2", "44", "dataset <code>own</code>; <code>render.hold_out: false</code>",
    ]  # fmt: skip
    assert found[2][3] == "images of <code>simple</code>, <code>own</code>"
    assert found[3][1:3] == ["", ""]


def test_every_set_is_in_every_test_with_the_mean_of_its_networks(text):
    for test in ("egad", "own"):
        found = rows(text, f"<h2>Tested on {test}</h2>")
        assert [line[0] for line in found] == ["simple", "own", "both", "given", "random"]
        assert [line[1] for line in found] == ["2", "2", "3", "", ""]
        for column, noise in ((2, "none"), (3, "stereo")):
            mean = np.mean([rate(test, noise, "both", seed) for seed in range(3)])
            assert found[2][column].startswith(percent(mean))
        assert [cell.partition(" <")[0] for cell in found[0][4:]] == ["50.0 %", "50.0 %"]
        assert "objects:" in found[0][2]
        assert "objects:" not in found[0][4]


def test_what_was_learnt_from_is_said_where_it_is_tried(text):
    """Objects of other datasets may have the same names."""
    egad, own = (text.partition(f"<h2>Tested on {name}</h2>")[2] for name in ("egad", "own"))
    assert "<code>own</code> were trained on 2 of them" in own
    assert "<code>both</code> were trained on 2 of them" in own
    assert "<code>simple</code> were trained" not in own
    egad = egad.partition("<h2>Tested on own</h2>")[0]
    assert "<code>simple</code> were trained on 1 of them" in egad
    assert "<code>own</code> were trained" not in egad


def test_pre_registered_comparisons_are_those_over_networks(text):
    found = rows(text, "<h2>Pre-registered comparisons</h2>")
    assert len(found) == 2 * 2 * 2
    assert [line[0] for line in found[:2]] == ["simple &minus; own", "simple &minus; random"]
    assert (found[0][1], found[2][1]) == ("egad, no noise", "egad, stereo noise")
    assert (found[0][2], found[1][2]) == ("2, 2", "2, 1")
    each = [[rate("egad", "none", name, seed) for seed in (0, 1)] for name in ("simple", "own")]
    result = difference(*each)
    assert found[0][3] == percent(result.gain)
    assert found[0][4] == " to ".join(map(percent, result.interval))
    assert "Pre-registered" not in page(results({**CONFIG, "comparisons": []}))


def test_the_spread_of_networks_is_told_for_each_set_and_for_all(text):
    found = rows(text.partition("<h2>Tested on egad</h2>")[2], "Standard deviation between")
    assert [line[0] for line in found] == ["both", "all"]
    each = [
        [rate("egad", "none", name, seed) for seed in range(count)]
        for name, count in (("simple", 2), ("own", 2), ("both", 3))
    ]
    assert found[0][1].startswith(percent(np.std(each[2], ddof=1)))
    squares = sum(np.square(np.subtract(values, np.mean(values))).sum() for values in each)
    assert found[1][1].startswith(percent(np.sqrt(squares / 4)))


def test_success_is_told_by_row_column_and_width(text):
    test = text.partition("<h2>Tested on egad</h2>")[2]
    section = test.partition("Success by difficulty, complexity and width, no noise")[2]
    head = re.findall(r"<th[^>]*>([^<]*)</th>", section.partition("</thead>")[0])
    assert head == [
        *("Training set", "A", "B", "C", "0", "1", "2"),
        *("to 20 mm", "20 to 45 mm", "above 45 mm"),
    ]
    both = pd.concat(tried("egad", "none", "own", seed, "") for seed in (0, 1))
    row = next(line for line in rows(section, "<table") if line[0] == "own")
    for place, labels in ((1, ["A0", "A1"]), (4, ["A0", "B0"]), (7, ["A0", "A1"]), (8, ["B0"])):
        mean = both[both["label"].isin(labels)]["success"].mean()
        assert row[place] == f"{round(100 * mean)}"


def test_trainings_are_told_with_their_last_epoch(text):
    found = rows(text, "Losses and scores of all networks")
    assert [line[0] for line in found][:3] == ["simple-0", "simple-1", "own-0"]
    assert found[1][1:3] == ["24", "0.1100"]
    assert found[1][4] == "75.0 %"


def test_a_name_cannot_break_the_page(text):
    assert "<code>&lt;given&gt;.pt</code>" in text
    assert "<given>" not in text


def test_given_weights_alone_have_no_training():
    known = {name: CONFIG[name] for name in ("egad", "training_sets")}
    found = page(results({**known, "sets": ["given"], "tests": ["egad"]}))
    assert "Validation loss" not in found
    assert "Learning curves" not in found
    assert [line[0] for line in rows(found, "<h2>Tested on egad</h2>")] == ["given"]
    assert "nan" not in re.sub(r'src="[^"]*"', "", found)


def test_each_curve_is_over_what_it_counts():
    """Sets with other numbers of objects than of images."""
    row = Row([0.8], True, (float("nan"), float("nan")))
    objects = [frozenset({("egad", str(n)) for n in range(count)}) for count in (3, 11)]
    images = {"some": Images(objects[0], 500), "all": Images(objects[1], 70)}
    curves = {"objects": ["some", "all"], "images": ["all", "some"]}
    found = learning_curves({"test": {"some": row, "all": row}}, images, curves)
    said = {kind: set(texts(svg)) for kind, svg in found.items()}
    assert {"3", "11", "training objects"} <= said["objects"]
    assert {"70", "500", "training images"} <= said["images"]
    assert not said["objects"] & {"70", "500"}


def test_sets_in_words():
    assert describe(TrainingSet(dataset="egad")) == "dataset `egad`"
    part = TrainingSet(dataset="egad", render={"complexity": (0.667, 1.0)}, training={"batch": 4})
    assert (
        describe(part) == "dataset `egad`; `render.complexity: [0.667, 1.0]`; `training.batch: 4`"
    )
    assert describe(TrainingSet(images=["a", "b"])) == "images of `a`, `b`"
    assert describe(TrainingSet(weights="w.pt")) == "given weights, `w.pt`, without training"


def test_sides_are_those_of_the_scaled_object_with_the_label():
    evaluation = pd.DataFrame({"label": ["A0", "B1"], "object_label": ["x", "y"]})
    sides = {"x": [0.01, 0.03, 0.04], "y": [0.02, 0.02, 0.07], "z": [0.5, 0.6, 0.7]}
    scales = pd.DataFrame(
        [[key, *sides[key]] for key in "yzx"], columns=["label", "after_1", "after_2", "after_3"]
    )
    assert object_sides(evaluation, scales) == {"A0": sides["x"], "B1": sides["y"]}
