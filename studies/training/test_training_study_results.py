"""The page about training sets, from the files that the workflow leaves."""

import numpy as np
import pytest
import write_study
from partial_tables import fill_columns, write_rows
from script_jobs import run_as_job
from study import page_settings, study_of
from study_tables import CLEARED, COMPARED

from egad.errors import TableError, UserError
from egad.learning.evaluation import Score, score_table
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.grasping import SCALES
from egad.tables.images import IMAGES
from egad.tables.training import HISTORY, SCORE

CONFIG = {
    "sets": ["all", "longer", "given"],
    "tests": ["egad"],
    "noise": ["none", "stereo"],
    "clutter": ["pile"],
    "references": ["random"],
    "comparisons": [["all", "longer"]],
    "training_sets": {
        "all": {"dataset": "egad"},
        "longer": {"images": ["all"], "seeds": 1},
        "given": {"weights": "given.pt"},
    },
}
SETTINGS = page_settings(study_of(CONFIG))
RATES = {"all-0": 0.8, "all-1": 0.7, "longer-0": 0.6, "given-0": 0.4, "random": 0.1}
LABELS = ["A0", "B1"]


def attempts(name):
    rng = np.random.default_rng(list(RATES).index(name))
    rows = [
        {"label": label, "id": f"id-{label}", "attempt": n, "initial_x": float(n)}
        for label in LABELS
        for n in range(5)
    ]
    won = rng.random(len(rows)) < RATES[name]
    table = fill_columns(TRIALS, rows).assign(success=won)
    return table.assign(outcome=np.where(won, "success", "collided"))


def rounds(name):
    """A round with two attempts."""
    rows = [{"scene": "pile", "noise": "none", "attempt": n, "n_objects": 2} for n in (0, 1)]
    table = fill_columns(CLUTTER, rows).assign(seed="ab", outcome="success", success=[True, False])
    return table.assign(id=name)


@pytest.fixture
def results(tmp_path):
    """A folder as the pipeline leaves it."""
    egad, made = tmp_path / "egad", tmp_path / "training_study"
    chosen = [{"label": label, "id": f"id-{label}", "object_label": label} for label in LABELS]
    write_rows(EVAL49, chosen, egad / "eval49.parquet")
    scales = [{"label": label, "after_1": 0.03} for label in LABELS]
    write_rows(SCALES, scales, egad / "rescaled/hand/scales.parquet")
    for name in RATES:
        for noise in ("none", "stereo"):
            path = made / "trials/egad" / noise / f"{name}.parquet"
            parquet.write(attempts(name), TRIALS, path)
        parquet.write(rounds(name), CLUTTER, made / "clutter/egad" / f"{name}.parquet")
    splits = [("id-A0", "train"), ("else", "train"), ("other", "validation"), ("id-B1", "test")]
    parts = [{"id": name, "objects": [name], "split": split} for name, split in splits]
    notes = {"shard": 0, "shards": 1}
    write_rows(IMAGES, parts, made / "images/all/images-0.parquet", notes)
    for network in ("all/0", "all/1", "longer/0"):
        folder = made / "networks" / network
        history = [{"images": 8}, {"epoch": 1}]
        write_rows(HISTORY, history, folder / "history.parquet")
        score = Score(3, 4, 2, (0.2, 0.9), 0.1)
        parquet.write(score_table(score), SCORE, folder / "score.parquet")
    return tmp_path


def run(results, settings=SETTINGS, name="results"):
    """The page and both tables."""
    outputs = [results / f"{name}{end}" for end in (".html", ".parquet", "-clutter.parquet")]
    write_study.run(settings, "hand", results, *outputs)
    return outputs


def test_the_tables_have_every_attempt_under_what_made_it(results):
    _, table, clutter = run(results)
    found = parquet.read(table, COMPARED)
    assert len(found) == 2 * len(RATES) * len(LABELS) * 5
    known = found.groupby("detector", sort=False)[["test", "training_set", "seed"]].first()
    assert known.index.tolist() == list(RATES)
    assert known["training_set"].tolist() == ["all", "all", "longer", "given", ""]
    assert known["seed"].tolist() == [0, 1, 0, 0, 0]
    for (name, noise), rows in found.groupby(["detector", "noise"]):
        assert noise in ("none", "stereo")
        assert rows["success"].tolist() == attempts(name)["success"].tolist()
        assert (rows["initial_pose"] != "").all()
    tables = parquet.read(clutter, CLEARED)
    assert tables["detector"].tolist() == [name for name in RATES for _ in range(2)]
    assert tables["id"].tolist() == tables["detector"].tolist()
    assert tables.groupby("detector", sort=False)["seed"].first().tolist() == [0, 1, 0, 0, 0]


def test_the_page_says_what_was_trained_on(results):
    text = run(results)[0].read_text(encoding="utf-8")
    for name in ("all", "longer"):
        assert f"<code>{name}</code> were trained on 1 of them" in text
        assert f'<th scope="row">{name}</th>\n<td>2</td><td>2</td>' in text


def test_without_clutter_its_table_is_empty(results):
    plan = SETTINGS.plan.model_copy(update={"clutter": []})
    *_, clutter = run(results, SETTINGS.model_copy(update={"plan": plan}))
    assert parquet.read(clutter, CLEARED).empty


def test_a_job_makes_the_same(results):
    page, *_ = run(results, name="a")
    settings = SETTINGS.model_dump(mode="json")
    run_as_job(
        write_study.run,
        "training_study",
        writes={
            "out": results / "b.html",
            "table": results / "b.parquet",
            "clutter": results / "b-clutter.parquet",
        },
        params={"settings": settings, "gripper": "hand", "results": str(results)},
    )
    assert (results / "b.html").read_bytes() == page.read_bytes()
    assert parquet.origin_of(results / "b.parquet")["stage"] == "training_study"


def test_drops_that_should_be_the_same_are_compared(results):
    path = results / "training_study/trials/egad/stereo/all-1.parquet"
    parquet.write(attempts("all-1").assign(initial_y=0.1), TRIALS, path)
    run(results)
    anew = SETTINGS.model_copy(
        update={"trials": SETTINGS.trials.model_copy(update={"reset": "redrop"})}
    )
    with pytest.raises(UserError, match="all-1 started attempt 0 at A0 with a different drop"):
        run(results, anew)


@pytest.mark.parametrize(
    "lost",
    [
        "trials/egad/none/all-1.parquet",
        "clutter/egad/random.parquet",
        "networks/all/1/score.parquet",
    ],
)
def test_a_file_that_is_missing_is_named(results, lost):
    (results / "training_study" / lost).unlink()
    with pytest.raises(TableError, match=lost.rpartition("/")[2]):
        run(results)
