"""Against the published set: EGAD_PUBLISHED names a folder of its objects (millimetres)."""

import os
import re
from pathlib import Path

import pytest
from scipy.stats import spearmanr

from egad.cli.measure import measure_files
from egad.io.folders import mesh_files
from egad.measures import MeasureMeshes
from egad_workflow.settings import Settings, select

FOLDER = os.environ.get("EGAD_PUBLISHED")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(FOLDER is None, reason="EGAD_PUBLISHED names no folder"),
]


@pytest.fixture(scope="module")
def table():
    files = {path.stem: path for path in mesh_files(Path(FOLDER))}
    return measure_files(select(Settings(), MeasureMeshes), files, "mm", 2)


def test_every_published_object_is_measured(table):
    assert (table["reason"] == "").all()


def test_complexity_orders_objects_as_the_published_numbers(table):
    numbers = [int(re.fullmatch(r"[A-Y](\d\d)_\d", name)[1]) for name in table["name"]]
    assert spearmanr(table["complexity"], numbers)[0] >= 0.96


def test_graspability_orders_objects_as_the_published_letters(table):
    assert spearmanr(-table["graspability"], [ord(name[0]) for name in table["name"]])[0] >= 0.9
