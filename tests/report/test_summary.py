import pytest

from egad.report import summary
from egad.report.data import DatasetReport


def test_published_coverage_is_of_places():
    theirs = summary.PUBLISHED.set_index("dataset").loc["EGAD, 2020"]
    assert theirs["coverage"] == pytest.approx(theirs["objects"] / 2500, abs=0.005)


def test_grasp_numbers(grasps):
    found = summary.grasp_numbers("yumi", grasps)
    assert (found["objects"], found["grasps"], found["per_object"]) == (40, 400, 10)
    assert found["collision_free"] == 0.25
    assert found["quality"][1] == pytest.approx(grasps["quality"].median())


def test_scale_numbers_of_what_is_there(report):
    found = summary.scale_numbers("egad_75mm", report.datasets["egad"])
    assert (found["scaled"]["objects"], found["scaled"]["changed"]) == (40, 10)
    assert found["scaled"]["factor"] == pytest.approx([0.8, 1, 1])
    assert found["printed"] == {"objects": 3, "plates": 2, "too_large": ["G6"]}
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
