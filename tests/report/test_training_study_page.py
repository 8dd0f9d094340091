"""The page about training sets, from made-up tables."""

import re

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f_oneway

from egad.pipeline.config import TrainingSet
from egad.pipeline.config.check import check
from egad.pipeline.config.stage_settings import TrainingStudyReport, select
from egad.pipeline.config.training_study import networks_of
from egad.pipeline.report.training_study import Images, Study, Training, describe, page
from egad.report.trials import EvaluationSet
from egad.tables.training import COMPARED, HISTORY

CONFIG = {
    "datasets": {
        "egad": {"source": "evolved"},
        "own": {"source": "meshes", "folder": ".", "units": "m"},
    },
    "training_study": {
        "sets": ["simple", "own", "given"],
        "seeds": 2,
        "tests": ["egad", "own"],
        "references": ["random"],
    },
    "training_sets": {
        "given": {"weights": "<given>.pt"},
        "own": {"dataset": "own", "hold_out": False},
        "simple": {"dataset": "egad", "complexity": [0.0, 0.333]},
    },
}
RATES = {"simple": 0.9, "own": 0.6, "given": 0.3, "": 0.1}
LABELS = ["A0", "A1", "B0", "C2"]


def tried(test, name, seed, detector):
    rng = np.random.default_rng([len(test), len(name), seed])
    rows = [
        (test, name, seed, label, f"{test} {label}", n, bool(won), detector, f"{n}")
        for label in LABELS
        for n, won in enumerate(rng.random(10) < RATES[name])
    ]
    columns = [*COMPARED.names[:6], "success", "detector", "initial_pose"]
    table = pd.DataFrame(rows, columns=columns).assign(quality=0.5)
    outcome = np.where(table["success"], "success", "collided")
    return table.assign(outcome=outcome)[COMPARED.names]


def history(seed):
    numbers = {name: np.linspace(0.5, 0.1 + 0.01 * seed, 3) for name in HISTORY.names}
    return pd.DataFrame(numbers | {"epoch": [0, 1, 2], "images": [8, 16, 24]})


def study(config=CONFIG):
    whole = check(config)
    found = networks_of(whole)
    names = [(each.training_set, each.seed, each.name) for each in found] + [("", 0, "random")]
    score = {
        "n_correct": 6,
        "n_images": 8,
        "objects": 4,
        "ci_low": 0.3,
        "ci_high": 0.9,
        "loss": 0.1,
    }
    trained = [each for each in found if each.training_set != "given"]
    settings = select(whole, TrainingStudyReport)
    by_name = dict(sorted(settings.training_sets.items()))  # as the workflow hands them over
    asked = whole.training_study
    return Study(
        settings=settings.model_copy(update={"training_sets": by_name}),
        table=pd.concat(tried(test, *name) for test in asked.tests for name in names),
        tests={test: EvaluationSet(3, 3) for test in asked.tests},
        images={
            each.training_set: Images(frozenset({"own A0", "own A1", "egad A0"}), 44)
            for each in trained
        },
        trainings={each: Training(history(each.seed), score) for each in trained},
    )


@pytest.fixture(scope="module")
def text():
    return page(study())


def rows(text, heading):
    """Cells of the first table after some text, a list a row."""
    table = text.partition(heading)[2].partition("<tbody>")[2].partition("</tbody>")[0]
    lines = re.findall(r"<tr.*?</tr>", table, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line, flags=re.DOTALL) for line in lines]
    return [[cell.replace("\N{NO-BREAK SPACE}", " ") for cell in line] for line in cells]


def test_the_page_needs_no_other_file_and_is_the_same_every_time(text):
    assert text == page(study())
    assert text.startswith("<!DOCTYPE html>")
    sources = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert sources
    assert all(source.startswith("data:image/svg+xml") for source in sources)
    assert "nan" not in re.sub(r'src="[^"]*"', "", text)


def test_the_sets_are_told_in_their_order(text):
    found = rows(text, "<h2>Training sets</h2>")
    assert [line[0] for line in found] == ["simple", "own", "given"]
    assert found[1][1:] == ["3", "44", "dataset <code>own</code>, all objects"]
    assert found[2][1:3] == ["", ""]


def test_every_set_is_in_every_test_with_its_networks(text):
    for test in ("egad", "own"):
        found = rows(text, f"<h2>Tested on {test}</h2>")
        assert [line[0] for line in found] == ["simple", "own", "given", "random"]
        simple = pd.concat(tried(test, "simple", seed, "") for seed in (0, 1))
        assert found[0][1] == f"{simple['success'].mean():.1%}".replace("%", " %")
        each = simple.groupby("seed")["success"].mean()
        assert found[0][3] == ", ".join(f"{rate:.1%}".replace("%", " %") for rate in each)
        assert found[2][3].count("%") == 1


def test_what_was_learnt_from_is_said_where_it_is_tried(text):
    """Objects of other datasets may have the same names."""
    own = text.partition("<h2>Tested on own</h2>")[2]
    assert "<code>own</code> were trained on 2 of them" in own
    assert [line[-1] for line in rows(own, "</p>")[:3]] == ["0", "2", "0"]
    egad = text.partition("<h2>Tested on egad</h2>")[2].partition("<h2>Tested on own</h2>")[0]
    assert "<code>simple</code> were trained on 1 of them" in egad
    assert "<code>own</code> were trained" not in egad


def test_every_pair_is_tested_and_corrected(text):
    found = rows(text.partition("<h2>Tested on egad</h2>")[2], "Differences between sets")
    assert [line[0] for line in found] == [
        "simple vs. own",
        "simple vs. given",
        "own vs. given",
    ]
    assert all(line[1] == str(len(LABELS)) for line in found)
    assert all(line[2] == "80 of 80" for line in found)


def test_a_pair_tells_the_difference_of_each_two_networks(text):
    found = rows(text.partition("<h2>Tested on egad</h2>")[2], "Differences between sets")
    simple, own = (
        [tried("egad", name, seed, "")["success"].mean() for seed in (0, 1)]
        for name in ("simple", "own")
    )
    gains = [100 * (one - other) for one, other in zip(simple, own, strict=True)]
    assert found[0][4] == ", ".join(f"{gain:.1f} %" for gain in gains).replace(
        "-", "\N{MINUS SIGN}"
    )


def test_the_luck_of_trainings_is_told_beside_them(text):
    for test in ("egad", "own"):
        each = [
            [tried(test, name, seed, "")["success"].mean() for seed in (0, 1)]
            for name in ("simple", "own")
        ]
        found = text.partition(f"<h2>Tested on {test}</h2>")[2].partition(
            "Variance between training seeds"
        )[2]
        said = re.sub(r"\s+", " ", found.partition("</p>")[0]).replace("\N{NO-BREAK SPACE}", " ")
        spread = np.sqrt(np.mean([np.var(rates, ddof=1) for rates in each]))
        assert f"standard deviation of {spread:.1%}".replace("%", " %") in said
        assert f"in {f_oneway(*each).pvalue:.1%}".replace("%", " %") in said
        assert "all 2 sets with several networks" in said


def test_trainings_are_told_with_their_last_epoch(text):
    found = rows(text, 'alt="Validation loss and score of all networks"')
    assert [line[0] for line in found] == ["simple-0", "simple-1", "own-0", "own-1"]
    assert found[1][1:3] == ["24", "0.1100"]
    assert found[1][4] == "75.0 %"


def test_a_name_cannot_break_the_page(text):
    assert "<code>&lt;given&gt;.pt</code>" in text
    assert "<given>" not in text


def test_given_weights_alone_have_no_training():
    alone = {"sets": ["given"], "tests": ["egad"]}
    found = page(study({**CONFIG, "training_study": alone}))
    assert "Validation loss" not in found
    assert "Differences between sets" not in found
    assert [line[0] for line in rows(found, "<h2>Tested on egad</h2>")] == ["given", "random"]


def test_sets_in_words():
    assert describe(TrainingSet(dataset="egad")) == (
        "dataset `egad`, all objects, without its evaluation set"
    )
    part = TrainingSet(dataset="egad", complexity=(0.667, 1.0), hold_out=False)
    assert describe(part) == "dataset `egad`, complexity ranks 0.667 to 1"
    few = TrainingSet(dataset="egad", subset=0.333)
    assert describe(few) == (
        "dataset `egad`, all objects, a random sample of 33.3%, without its evaluation set"
    )
    assert describe(TrainingSet(weights="w.pt")) == "given weights, `w.pt`, without training"
