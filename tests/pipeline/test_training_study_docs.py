"""What docs/training-study.md is written with: twins and rates against slow counts, luck."""

import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from egad.pipeline.cli.common import settings_in
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS
from egad.tables.training import COMPARED

ROOT = Path(__file__).parents[2]
EXPERIMENTS = ROOT / "experiments"
NAMES = [f"o{number:02}" for number in range(30)]


@pytest.fixture(scope="module")
def twins():
    return runpy.run_path(str(EXPERIMENTS / "twins.py"))


def write(schema, rows, path):
    """A table with nothing in the columns that are not given."""
    kinds = {pa.string(): "", pa.large_binary(): b"", pa.binary(): b""}
    zeros = {
        field.name: [] if pa.types.is_list(field.type) else kinds.get(field.type, 0)
        for field in schema
    }
    parquet.write(pd.DataFrame([zeros | row for row in rows]), schema, path)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """All objects but the last are the same; the first and the last are the evaluation set."""
    folder = tmp_path_factory.mktemp("results") / "egad"
    solids = [b"\x0f" * 10] * (len(NAMES) - 1) + [b"\xf0" * 10]
    archive = [{"id": name, "voxels": bits} for name, bits in zip(NAMES, solids, strict=True)]
    write(ARCHIVE, archive, folder / "archive.parquet")
    objects = [{"id": name, "label": name, "complexity": n} for n, name in enumerate(NAMES)]
    write(OBJECTS, objects, folder / "objects.parquet")
    write(SCALES, objects, folder / "rescaled/egad_75mm/scales.parquet")
    write(EVAL49, [{"id": NAMES[0]}, {"id": NAMES[-1]}], folder / "eval49.parquet")
    return folder


def test_overlaps_are_those_of_sets_of_voxels(twins):
    rng = np.random.default_rng(3)
    one, other = (rng.integers(0, 2, (count, 50), dtype=np.uint8) for count in (4, 6))
    found = twins["overlaps"](one, other)
    for i, j in np.ndindex(4, 6):
        first, second = (set(np.flatnonzero(bits)) for bits in (one[i], other[j]))
        assert found[i, j] == pytest.approx(len(first & second) / len(first | second))


def test_what_is_learnt_from_is_of_the_set_and_not_of_the_evaluation_set(twins, dataset):
    settings = settings_in(ROOT / "config/training_study.yaml")
    found = {
        name: set(twins["learnt"](settings, name, dataset, "egad_75mm"))
        for name in ("evolved", "simple", "complex")
    }
    assert len(found["evolved"]) == 24  # 3 are for testing, 3 for validation
    assert not found["evolved"] & {NAMES[0], NAMES[-1]}
    assert found["simple"] == found["evolved"] & set(NAMES[:10])
    assert found["complex"] == found["evolved"] & set(NAMES[20:])


def test_every_set_of_the_dataset_has_its_twins(twins, dataset, capsys):
    twins["main"](dataset, "egad_75mm")
    head, _, *lines = capsys.readouterr().out.splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    settings = settings_in(ROOT / "config/training_study.yaml")
    sets = settings.training_sets
    assert [row[0] for row in rows] == [
        f"`{name}`" for name in settings.training_study.sets if sets[name].dataset == "egad"
    ]
    assert head.endswith("above 0.9, of 2 |")
    assert all(row[2:] == ["0.50", "1"] for row in rows)


def test_luck_of_trainings_is_no_news_to_the_test_only_where_there_is_none():
    by_luck = runpy.run_path(str(EXPERIMENTS / "seed_variance.py"))["by_luck"]
    by_luck.__globals__["REPEATS"] = 200
    assert by_luck(0.0, 0.0) < 0.1
    assert by_luck(0.0, 0.1) < 0.1
    assert by_luck(0.06, 0.0) > 0.5


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    """Attempts of two sets of two networks and of a detector, and where they are written."""
    rng = np.random.default_rng(5)
    names = [("few", 0), ("few", 1), ("many", 0), ("many", 1), ("", 0)]
    labels = [f"{row}{column}" for row in "ABG" for column in range(3)]
    rows = [
        {"test": "own", "training_set": name, "seed": seed, "id": label, "label": label}
        | {
            "attempt": attempt,
            "detector": f"{name or 'random'}-{seed}",
            "initial_pose": str(attempt),
        }
        | {"outcome": "success" if rng.random() < 0.7 - 0.1 * seed else "missed"}
        for name, seed in names
        for label in labels
        for attempt in range(4)
    ]
    table = pd.DataFrame(rows).assign(quality=0.5)
    table = table.assign(success=table["outcome"] == "success")
    results = tmp_path_factory.mktemp("tried")
    parquet.write(table[COMPARED.names], COMPARED, results / "training_study/results.parquet")
    objects = [{"id": label, "label": f"{label}, own"} for label in labels]
    write(OBJECTS, objects, results / "own/objects.parquet")
    scaled = [
        {"label": f"{label}, own", "after_1": {"A": 0.01, "B": 0.04, "G": 0.06}[label[0]]}
        for label in labels
    ]
    write(SCALES, scaled, results / "own/rescaled/hand/scales.parquet")
    return results / "training_study/results.parquet", table


def tables(text):
    """Printed tables by their first heading: cells by the first one of their line."""
    found = {}
    for block in text.strip().split("\n\n"):
        if not block.startswith("|"):
            continue
        head, _, *lines = [
            [cell.strip() for cell in line.split("|")] for line in block.splitlines()
        ]
        found[head[1]] = {line[1]: line[2:-1] for line in lines}
    return found


def test_tables_of_the_experiment_are_counts_of_its_attempts(tried, monkeypatch, capsys):
    path, table = tried
    program = runpy.run_path(str(EXPERIMENTS / "training_study.py"))
    monkeypatch.setitem(program["main"].__globals__, "DOCS", path.parent)
    program["main"](path)
    text = capsys.readouterr().out
    said = tables(text)
    few = table[table["training_set"] == "few"]
    rate = few["success"].mean()
    by_seed = few.groupby("seed")["success"].mean()
    by_row = few.groupby(few["label"].str[0])["success"].mean()
    pooled, each = said["success on own, %"]["`few`"]
    assert pooled.startswith(f"{100 * rate:.0f} (")
    assert each == ", ".join(f"{100 * part:.0f}" for part in by_seed)
    assert said["attempts on own, %"]["`few`"] == [f"{100 * rate:.1f}", f"{100 - 100 * rate:.1f}"]
    expected = [f"{100 * by_row[row]:.0f}" if row in by_row else "" for row in "ABCDEFG"]
    assert said["by row on own, %"]["`few`"] == expected
    sizes = said["by shortest side on own, %"]
    assert sizes["objects of the dataset"] == ["33", "33", "33"]
    assert sizes["`few`"] == [f"{100 * by_row[row]:.0f}" for row in "ABG"]
    assert "within sets: standard deviation" in text
    assert f"few, {rate:.0%}" in (path.parent / "training-study-own.svg").read_text()
