"""The page about training sets, from the files that the workflow leaves."""

import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from egad.errors import TableError, UserError
from egad.learning.evaluation import Score, score_table
from egad.pipeline.cli import main
from egad.pipeline.config.check import check
from egad.pipeline.config.stage_settings import TrainingStudyReport, select
from egad.pipeline.stages import training_study as stage
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.images import IMAGES
from egad.tables.training import COMPARED, HISTORY, SCORE

CONFIG = {
    "training_study": {"sets": ["all", "given"], "tests": ["egad"], "references": ["random"]},
    "training_sets": {"all": {"dataset": "egad"}, "given": {"weights": "given.pt"}},
    "select_eval": {"rows": 2, "columns": 2},
}
SETTINGS = select(check(CONFIG), TrainingStudyReport)
RATES = {"all-0": 0.8, "all-1": 0.7, "given-0": 0.4, "random": 0.1}
LABELS = ["A0", "B1"]


def empty(kind):
    if pa.types.is_list(kind):
        return []
    zeros = {pa.string(): "", pa.large_binary(): b"", pa.bool_(): False}
    return zeros.get(kind, 0)


def blank(schema, rows):
    zeros = {field.name: empty(field.type) for field in schema}
    return pd.DataFrame([zeros | row for row in rows])


def attempts(name):
    rng = np.random.default_rng(list(RATES).index(name))
    rows = [
        {"label": label, "id": f"id-{label}", "attempt": n, "initial_x": float(n)}
        for label in LABELS
        for n in range(5)
    ]
    won = rng.random(len(rows)) < RATES[name]
    table = blank(TRIALS, rows).assign(success=won)
    return table.assign(outcome=np.where(won, "success", "collided"))


@pytest.fixture
def results(tmp_path):
    """A folder as the pipeline leaves it."""
    egad, made = tmp_path / "egad", tmp_path / "training_study"
    chosen = [{"label": label, "id": f"id-{label}"} for label in LABELS]
    parquet.write(blank(EVAL49, chosen), EVAL49, egad / "eval49.parquet")
    for name in RATES:
        parquet.write(attempts(name), TRIALS, egad / "trials" / "hand" / f"{name}.parquet")
    splits = [("id-A0", "train"), ("else", "train"), ("other", "validation"), ("id-B1", "test")]
    parts = [{"id": name, "split": split} for name, split in splits]
    notes = {"shard": 0, "shards": 1}
    parquet.write(blank(IMAGES, parts), IMAGES, made / "images/all/images-0.parquet", notes)
    for seed in (0, 1):
        folder = made / "networks/all" / str(seed)
        parquet.write(
            blank(HISTORY, [{"images": 8}, {"epoch": 1}]),
            HISTORY,
            folder / "history.parquet",
        )
        score = Score(3, 4, 2, (0.2, 0.9), 0.1)
        parquet.write(score_table(score), SCORE, folder / "score.parquet")
    return tmp_path


def test_the_table_has_every_attempt_under_what_made_it(results):
    out, table = results / "report.html", results / "results.parquet"
    stage.run(SETTINGS, "hand", results, out, table)
    found = parquet.read(table, COMPARED)
    assert len(found) == len(RATES) * len(LABELS) * 5
    known = found.groupby("detector", sort=False)[["test", "training_set", "seed"]].first()
    assert known.index.tolist() == list(RATES)
    assert known["training_set"].tolist() == ["all", "all", "given", ""]
    assert known["seed"].tolist() == [0, 1, 0, 0]
    assert set(known["test"]) == {"egad"}
    for name, rows in found.groupby("detector"):
        assert rows["success"].tolist() == attempts(name)["success"].tolist()
        assert (rows["initial_pose"] != "").all()


def test_the_page_says_what_was_trained_on(results):
    out = results / "report.html"
    stage.run(SETTINGS, "hand", results, out, results / "results.parquet")
    text = out.read_text(encoding="utf-8")
    assert "<code>all</code> were trained on 1 of them" in text
    assert '<th scope="row">all</th>\n<td>2</td><td>2</td>' in text


def test_the_command_makes_the_same(results, monkeypatch, capsys):
    stage.run(SETTINGS, "hand", results, results / "a.html", results / "a.parquet")
    words = ["--settings", SETTINGS.model_dump_json(), "--gripper", "hand"]
    paths = ["--results", results, "--out", results / "b.html", "--table", results / "b.parquet"]
    monkeypatch.setattr(sys, "argv", ["egad", "training-study", *words, *map(str, paths)])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code in (0, None), capsys.readouterr().err
    assert (results / "b.html").read_bytes() == (results / "a.html").read_bytes()
    assert parquet.origin_of(results / "b.parquet")["stage"] == "training_study"


def test_drops_that_should_be_the_same_are_compared(results):
    path = results / "egad/trials/hand/all-1.parquet"
    parquet.write(attempts("all-1").assign(initial_y=0.1), TRIALS, path)
    outputs = results / "out.html", results / "out.parquet"
    stage.run(SETTINGS, "hand", results, *outputs)
    assert "10 of 20" in outputs[0].read_text(encoding="utf-8")
    anew = SETTINGS.model_copy(
        update={"trials": SETTINGS.trials.model_copy(update={"reset": "redrop"})}
    )
    with pytest.raises(UserError, match="all-1 started attempt 0 at A0 with a different drop"):
        stage.run(anew, "hand", results, *outputs)


@pytest.mark.parametrize(
    "lost", ["egad/trials/hand/all-1.parquet", "training_study/networks/all/1/score.parquet"]
)
def test_a_file_that_is_missing_is_named(results, lost):
    (results / lost).unlink()
    with pytest.raises(TableError, match=lost.rpartition("/")[2]):
        stage.run(SETTINGS, "hand", results, results / "out.html", results / "out.parquet")
