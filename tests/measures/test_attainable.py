import math

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.grasps import ferrari_canny
from egad.measures import (
    Attainable,
    MeasureParameters,
    MeasureSpace,
    attainable_graspability,
    coverage,
    default_measures,
)
from egad_workflow.settings import Settings, select

DEFAULT = default_measures(egad.gripper("yumi"), 0)


def measured(**sections):
    return select(Settings.model_validate(sections), MeasureParameters)


def test_the_highest_quality_is_nearly_that_of_a_grasp_through_the_center_of_mass():
    """The hull is not flat around the wrench of torsion, so a little less is reached."""
    points = [[[0, 0, -0.02], [0, 0, 0.02]]]
    normals = [[[0, 0, -1], [0, 0, 1]]]
    best = ferrari_canny(points, normals, [[0, 0, 1]], [0, 0, 0])[0]
    limit = attainable_graspability(DEFAULT).quality
    assert limit == pytest.approx(np.pi * 0.005**2 * 0.5 * 100, rel=1e-8)
    assert (1 - 1e-4) * limit < best <= limit


@pytest.mark.parametrize("quality", [{}, {"friction": 0.8}, {"finger_radius": 0.003}])
def test_no_random_grasp_is_better(quality):
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(500, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    normals = np.stack([-axes, axes], axis=1) + 0.2 * rng.normal(size=(500, 2, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    middles, half = 0.002 * rng.normal(size=(500, 3)), 0.02 * axes
    points = np.stack([middles - half, middles + half], axis=1)
    found = ferrari_canny(points, normals, axes, [0, 0, 0], **quality)
    limit = attainable_graspability(measured(quality=quality)).quality
    assert 0.9 * limit < found.max() <= limit


def test_a_ball_is_a_case_of_the_model_and_is_measured_as_it_says():
    """Its center of mass lies midway between the contacts of every grasp."""
    tangent = 0.25 * DEFAULT.sampling.cone  # a quarter of the grasps lean less
    lean = math.atan(tangent)
    best = attainable_graspability(DEFAULT).quality
    expected = best * math.cos(lean) ** 2 / math.hypot(1, 100 * 0.02 * math.sin(lean))
    found = egad.measure(trimesh.creation.icosphere(5))
    assert found.graspability == pytest.approx(expected, rel=0.003)
    assert expected < attainable_graspability(DEFAULT).graspability < best


def test_rows_a_and_b_lie_above_what_is_expected():
    limit = attainable_graspability(DEFAULT)
    assert (limit.rows, limit.row_names) == (2, "rows A and B")
    assert limit.edge == pytest.approx(0.0005 + 0.0035 * 23 / 25)
    assert limit.edge > limit.graspability > limit.edge - 0.0035 / 25


def test_few_released_objects_lie_above_what_is_expected_and_none_in_these_rows():
    table = egad.load("released").table
    limit = attainable_graspability(DEFAULT)
    assert (table["graspability"] > limit.graspability).mean() < 0.005
    assert table["graspability"].max() < limit.edge


def test_the_rows_follow_the_settings():
    weak = attainable_graspability(measured(quality={"finger_radius": 0.0025}))
    assert weak.quality == pytest.approx(attainable_graspability(DEFAULT).quality / 4)
    assert weak.rows == 22
    assert weak.row_names == "rows A to V"
    wide = attainable_graspability(measured(space={"graspability_range": (0.0005, 0.003)}))
    assert (wide.rows, wide.row_names, wide.edge) == (0, "", math.inf)
    one = attainable_graspability(measured(space={"graspability_range": (0.0005, 0.0038)}))
    assert (one.rows, one.row_names) == (1, "row A")


@pytest.mark.parametrize(
    "sections",
    [{"graspability": {"metric": "robust"}}, {"measures": {"graspability": "own.py:slenderness"}}],
)
def test_other_measures_have_no_limit(sections):
    assert attainable_graspability(measured(**sections)) == Attainable(
        math.inf, math.inf, 0, math.inf
    )


def test_coverage_of_attainable_rows_leaves_out_the_others_and_what_lies_there():
    space = MeasureSpace(cells=5, elites_per_cell=2)
    cells = [(0, 0), (0, 1), (0, 1), (0, 1), (3, 4)]  # of column and row
    table = pd.DataFrame(cells, columns=["complexity_cell", "difficulty_cell"])
    assert coverage(table, space, 0) == coverage(table, space)
    assert coverage(table, space, 1) == 3 / 40
    assert coverage(table, space, 2) == 1 / 30
