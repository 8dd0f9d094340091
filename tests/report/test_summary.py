import numpy as np
import pandas as pd
import pytest

from egad.pipeline.config import Space
from egad.report import summary
from egad.report.data import DatasetReport


def test_published_coverage_is_of_places():
    theirs = summary.PUBLISHED.set_index("dataset").loc["EGAD, 2020"]
    assert theirs["coverage"] == pytest.approx(theirs["objects"] / 2500, abs=0.005)


def test_the_table_for_a_terminal_has_ours_above_the_published(report):
    comparison = report.comparison.assign(diversity_max=[0.3, np.nan])
    head, egad, mine, published, *theirs = summary.comparison_text(comparison).splitlines()
    assert head.split() == ["dataset", "objects", "coverage", "diversity:", "min", "max", "mean"]
    assert egad.split() == ["egad", "40", "1.6", "%", "0.10", "0.30", "0.20"]
    assert mine.split() == ["mine", "12", "0.5", "%", "0.12", "-", "0.21"]
    assert published == "published"
    assert theirs[1].split() == ["YCB", "78", "3", "%", "0.11", "0.65", "0.19"]
    assert len({len(line) for line in (head, egad, mine, *theirs)}) == 1


def test_grasp_numbers(grasps):
    found = summary.grasp_numbers("yumi", grasps)
    assert (found["objects"], found["grasps"], found["per_object"]) == (40, 400, 10)
    assert found["collision_free"] == 0.25
    assert found["quality"][1] == pytest.approx(grasps["quality"].median())


def test_scale_numbers_of_what_is_there(report):
    found = summary.scale_numbers("egad_75mm", report.datasets["egad"])
    assert (found["scaled"]["objects"], found["scaled"]["changed"]) == (40, 10)
    assert found["scaled"]["factor"] == pytest.approx([0.8, 1, 1])
    assert found["printed"] == {"objects": 3, "plates": 2, "on_no_plate": ["G6"]}
    bare = DatasetReport(report.datasets["egad"].objects, report.datasets["egad"].rejected)
    assert summary.scale_numbers("yumi", bare)["scaled"] is None


def test_rejections_and_outcomes_are_ordered_by_frequency(report, trials):
    counts = summary.rejection_counts(report.datasets["egad"].rejected)
    assert [row["count"] for row in counts] == [2, 1]
    assert counts[0]["reason"] == "no volume"
    assert summary.outcome_counts(trials) == {
        "success": 15,
        "missed": 12,
        "no_grasp": 8,
        "slipped": 5,
    }
    assert next(iter(summary.outcome_counts(trials))) == "success"


def test_regrading_counts_moves_and_coverage():
    """Four objects selected for one cell; two lie beside it, on either side, one farther off."""
    space = Space(cells=7, difficulty_range=(0, 0.007), elites_per_cell=4)
    objects = pd.DataFrame(
        {
            "archive_difficulty": [0.0055] * 4 + [np.nan],
            "complexity_cell": [2] * 5,
            "difficulty_cell": [1, 0, 2, 4, 0],
        }
    )
    found = summary.regrading(objects, space)
    assert (found["stayed"], found["by_one"], found["by_more"]) == (0.25, 0.5, 0.25)
    assert found["mean"] == 0.75
    assert found["before"] == found["after"] == 4 / 196
    assert summary.regrading(objects.tail(1), space) is None
