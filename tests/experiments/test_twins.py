"""Twins of an evaluation set among training objects, against slow counts."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import yaml
from partial_tables import write_rows
from study import read_study

from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS

STUDY = Path(__file__).parents[2] / "experiments/training_study"
NAMES = [f"o{number:02}" for number in range(30)]


@pytest.fixture(scope="module")
def twins():
    return runpy.run_path(str(STUDY / "twins.py"))


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    """Sets of two datasets."""
    sets = {
        "evolved": {"dataset": "egad"},
        "simple": {"dataset": "egad", "render": {"complexity": [0.0, 0.333]}},
        "complex": {"dataset": "egad", "render": {"complexity": [0.667, 1.0]}},
        "ycb": {"dataset": "ycb"},
        "longer": {"images": ["evolved"]},
    }
    values = {
        "egad": {
            "datasets": {
                "egad": {"source": "evolved"},
                "ycb": {"source": "primitives", "objects": 9},
            }
        },
        "training_sets": sets,
        "sets": list(sets),
        "tests": ["egad"],
    }
    path = tmp_path_factory.mktemp("config") / "study.yaml"
    path.write_text(yaml.safe_dump(values))
    return path


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """All objects but the last are the same; the first and the last are the evaluation set."""
    folder = tmp_path_factory.mktemp("results") / "egad"
    solids = [b"\x0f" * 10] * (len(NAMES) - 1) + [b"\xf0" * 10]
    archive = [{"id": name, "voxels": bits} for name, bits in zip(NAMES, solids, strict=True)]
    write_rows(ARCHIVE, archive, folder / "archive.parquet")
    objects = [{"id": name, "label": name, "complexity": n} for n, name in enumerate(NAMES)]
    write_rows(OBJECTS, objects, folder / "objects.parquet")
    write_rows(
        SCALES, [{"label": name} for name in NAMES], folder / "rescaled/egad_75mm/scales.parquet"
    )
    write_rows(EVAL49, [{"id": NAMES[0]}, {"id": NAMES[-1]}], folder / "eval49.parquet")
    return folder


def test_overlaps_are_those_of_sets_of_voxels(twins):
    rng = np.random.default_rng(3)
    one, other = (rng.integers(0, 2, (count, 50), dtype=np.uint8) for count in (4, 6))
    found = twins["overlaps"](one, other)
    for i, j in np.ndindex(4, 6):
        first, second = (set(np.flatnonzero(bits)) for bits in (one[i], other[j]))
        assert found[i, j] == pytest.approx(len(first & second) / len(first | second))


def test_what_is_learnt_from_is_of_the_set_and_not_of_the_evaluation_set(twins, dataset, config):
    study = read_study(config)
    found = {
        name: set(twins["learnt"](study, name, dataset, "egad_75mm"))
        for name in ("evolved", "simple", "complex")
    }
    assert len(found["evolved"]) == 24  # 3 are for testing, 3 for validation
    assert not found["evolved"] & {NAMES[0], NAMES[-1]}
    assert found["simple"] == found["evolved"] & set(NAMES[:10])
    assert found["complex"] == found["evolved"] & set(NAMES[20:])


def test_every_set_of_the_dataset_has_its_twins(twins, dataset, config, capsys):
    twins["main"](dataset, "egad_75mm", config)
    head, _, *lines = capsys.readouterr().out.splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    assert [row[0] for row in rows] == ["`evolved`", "`simple`", "`complex`"]
    assert head.endswith("above 0.9, of 2 |")
    assert all(row[2:] == ["0.50", "1"] for row in rows)
