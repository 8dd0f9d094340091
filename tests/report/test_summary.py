import numpy as np

from egad.report.axes import USUAL
from egad.report.summary import rejection_counts, section, summarize


def test_rejections_are_ordered_by_frequency(report):
    counts = rejection_counts(report.datasets["egad"].rejected)
    assert [row["count"] for row in counts] == [2, 1]
    assert counts[0]["reason"] == "no volume"


def test_a_dataset_in_numbers(objects, settings):
    found = summarize("evolved", objects, settings.space, 3, {})
    cells = objects.groupby(["complexity_cell", "difficulty_cell"]).size()
    assert (found.objects, found.filled_cells) == (40, len(cells))
    assert found.coverage == cells.clip(upper=4).sum() / 2500
    assert (
        found.diversity[0] < found.diversity[1] < found.diversity[2] == objects["diversity"].max()
    )


def test_dropped_bodies_are_counted_and_said(objects, settings):
    none = summarize("given", objects, settings.space, 0, {})
    assert none.cut == 0
    bodies, volumes = np.zeros(40, int), np.zeros(40)
    bodies[:3], volumes[:3] = [1, 2, 1], [0.1, 0.48, 0.2]
    cut = objects.assign(dropped_bodies=bodies, dropped_volume=volumes)
    found = summarize("given", cut, settings.space, 0, {})
    assert (found.cut, found.dropped_volume) == (3, 0.48)
    shown = section({"parts": found}, settings.space, USUAL, 49).html
    assert "The meshes of 3 objects had several bodies" in shown
    assert "up to 48.0 % of the volume" in shown.replace("\N{NO-BREAK SPACE}", " ")
    assert "several bodies" not in section({"parts": none}, settings.space, USUAL, 49).html
