"""What docs/diversity.md is written with: twins against a slow count, luck against what must be."""

import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from egad.cli.common import settings_in
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS

DOCS = Path(__file__).parents[1] / "docs"
NAMES = [f"o{number:02}" for number in range(30)]


@pytest.fixture(scope="module")
def twins():
    return runpy.run_path(str(DOCS / "twins.py"))


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
    settings = settings_in(DOCS.parent / "config/diversity.yaml")
    found = {
        name: set(twins["learnt"](settings, name, dataset, "egad_75mm"))
        for name in ("evolved", "simple", "complex")
    }
    assert len(found["evolved"]) == 27  # a tenth, 3, is for testing
    assert not found["evolved"] & {NAMES[0], NAMES[-1]}
    assert found["simple"] == found["evolved"] & set(NAMES[:10])
    assert found["complex"] == found["evolved"] & set(NAMES[20:])


def test_every_set_of_the_dataset_has_its_twins(twins, dataset, capsys):
    twins["main"](dataset, "egad_75mm")
    head, _, *lines = capsys.readouterr().out.splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    settings = settings_in(DOCS.parent / "config/diversity.yaml")
    sets = settings.training_sets
    assert [row[0] for row in rows] == [
        f"`{name}`" for name in settings.diversity.sets if sets[name].dataset == "egad"
    ]
    assert head.endswith("above 0.9, of 2 |")
    assert all(row[2:] == ["0.50", "1"] for row in rows)


def test_luck_of_trainings_is_no_news_to_the_test_only_where_there_is_none():
    by_luck = runpy.run_path(str(DOCS / "diversity.py"))["by_luck"]
    by_luck.__globals__["REPEATS"] = 200
    assert by_luck(0.0, 0.0) < 0.1
    assert by_luck(0.0, 0.1) < 0.1
    assert by_luck(0.06, 0.0) > 0.5
