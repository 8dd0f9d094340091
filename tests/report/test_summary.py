from egad.report.summary import rejection_counts, summarize


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
