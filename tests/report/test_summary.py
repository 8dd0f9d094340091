import numpy as np
import pandas as pd

from egad.report.summary import DatasetSummary, name_stages, rejection_counts, section


def test_rejections_are_ordered_by_frequency(report):
    counts = rejection_counts(report.datasets["egad"].rejected)
    assert [row["count"] for row in counts] == [2, 1]
    assert counts[0]["reason"] == "no volume"


def test_a_dataset_in_numbers(objects, settings):
    found = DatasetSummary(objects, settings.space, None, {})
    cells = objects.groupby(["complexity_cell", "difficulty_cell"]).size()
    assert len(found.objects) == 40
    assert found.coverage == cells.clip(upper=4).sum() / 2500


def test_a_few_own_objects_have_no_coverage(objects, settings):
    found = DatasetSummary(objects.head(7), settings.space, objects.head(7), {}, listed=True)
    shown = section({"parts": found}, 49).html
    assert "overage" not in shown
    assert "Evolved" not in shown
    assert "of 49" not in shown


def test_it_is_said_what_an_object_is_left_out_of():
    stages = ["postprocess", "print-export panda", "bundle yumi", "other"]
    rejected = pd.DataFrame({"id": ["b", "a", "a", "c"], "stage": stages, "reason": "thin"})
    shown = name_stages(rejected)
    assert shown["id"].tolist() == ["a", "a", "b", "c"]
    words = ["printing for panda", "simulation for yumi", "the dataset", "other"]
    assert shown["stage"].tolist() == words


def test_dropped_bodies_are_counted_and_said(objects, settings):
    none = DatasetSummary(objects, settings.space, None, {})
    assert none.cut == 0
    bodies, volumes = np.zeros(40, int), np.zeros(40)
    bodies[:3], volumes[:3] = [1, 2, 1], [0.1, 0.48, 0.2]
    cut = objects.assign(dropped_bodies=bodies, dropped_volume=volumes)
    found = DatasetSummary(cut, settings.space, None, {})
    assert found.cut == 3
    shown = section({"parts": found}, 49).html
    assert "The meshes of 3 objects had several bodies" in shown
    assert "up to 48.0 % of the volume" in shown.replace("\N{NO-BREAK SPACE}", " ")
    assert "several bodies" not in section({"parts": none}, 49).html
