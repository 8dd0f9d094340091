from functools import partial

import pytest
import trimesh

from egad.errors import RejectedError, UserError
from egad.measures import CustomMeasures
from egad.measures.custom import check_measures, plugin_value
from egad.measures.graspability import rough_graspability
from egad.measures.measure import measure_mesh
from egad.measures.parameters import MeasureParameters
from egad.plugins import source_hash
from egad.random import generator
from egad_workflow.settings import Settings, select

CODE = """
import numpy as np

def longest(mesh): return mesh.extents.max()
def spoils(mesh):
    mesh.vertices *= 0
    return mesh.extents.max()
def wide_open(mesh): return 1 / 0
def unknown(mesh): return float("nan")
def endless(mesh): return float("inf")
def nothing(mesh): return None
def greedy(mesh): return np.ones(1 << 50).sum()
number = 3
"""
BOX = trimesh.creation.box((0.1, 0.06, 0.04))


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(CODE)
    return path


def placed(axes):
    settings = select(Settings(measures=axes), MeasureParameters)
    estimate = partial(rough_graspability, settings=settings, rng=generator(0, "test"))
    return measure_mesh(BOX, settings, estimate)


def test_the_value_is_that_of_the_function(file):
    assert plugin_value(f"{file}:longest", BOX) == pytest.approx(0.1)


def test_a_function_cannot_spoil_the_mesh(file):
    plugin_value(f"{file}:spoils", BOX)
    assert BOX.extents.max() == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("wide_open", "wide open failed in line 8 of mine.py: ZeroDivisionError: division by zero"),
        ("unknown", r"unknown is not a finite number \(nan\)"),
        ("endless", r"endless is not a finite number \(inf\)"),
        ("nothing", "nothing must be a number, got NoneType"),
    ],
)
def test_what_is_no_number_rejects_the_object(file, name, reason):
    with pytest.raises(RejectedError, match=reason):
        plugin_value(f"{file}:{name}", BOX)


def test_want_of_memory_is_no_reason_to_reject_an_object(file):
    with pytest.raises(MemoryError):
        plugin_value(f"{file}:greedy", BOX)


@pytest.mark.parametrize(
    ("measure", "words"),
    [
        ("nowhere.py:longest", "no such file or module"),
        ("no.such.package:longest", "no such file or module"),
        ("{file}:missing", "no function missing"),
        ("{file}:number", "no function number"),
    ],
)
def test_a_measure_that_is_not_there_is_the_users_mistake(file, measure, words):
    with pytest.raises(UserError, match=words):
        check_measures(CustomMeasures(complexity=measure.format(file=file)))


def test_own_measures_take_the_place_of_the_coordinates(file):
    usual = placed(CustomMeasures())
    across = placed(CustomMeasures(complexity=f"{file}:longest"))
    assert across.complexity == pytest.approx(0.1)
    assert (across.graspability, across.grasps) == (usual.graspability, usual.grasps)
    upwards = placed(CustomMeasures(graspability=f"{file}:longest"))
    assert (upwards.complexity, upwards.grasps) == (usual.complexity, 0)
    assert upwards.graspability == pytest.approx(0.1)


def test_a_changed_file_has_another_fingerprint(file):
    before = source_hash(f"{file}:longest", "measures")
    assert source_hash(f"{file}:longest", "measures") == before
    file.write_text(CODE.replace("max", "min", 1))
    assert source_hash(f"{file}:longest", "measures") != before


def test_a_module_that_is_installed_will_do():
    measure = "egad.measures.complexity:complexity"
    assert plugin_value(measure, BOX) == pytest.approx(placed(CustomMeasures()).complexity)
    assert len(source_hash(measure, "measures")) == 16
