import compare
import numpy as np
import pandas as pd
import pytest
from partial_tables import fill_columns

from egad.measures import MeasureParameters
from egad.tables import parquet
from egad.tables.objects import COMPARISON, OBJECTS
from egad_workflow.settings import Settings, select


def objects(count):
    """Objects along the diagonal of the space, two a cell."""
    cells = np.arange(count) // 2
    diversity = np.linspace(0.1, 0.3, count)
    places = {"complexity_cell": cells, "difficulty_cell": cells, "diversity": diversity}
    return fill_columns(OBJECTS, pd.DataFrame(places))


def test_datasets_are_counted_drawn_and_told(tmp_path):
    paths = {}
    for name, count in (("few", 5), ("more", 20)):
        paths[name] = tmp_path / f"{name}.parquet"
        parquet.write(objects(count), OBJECTS, paths[name])
    table, figure = tmp_path / "comparison.parquet", tmp_path / "comparison.svg"
    text = compare.run(
        select(Settings(), MeasureParameters), list(paths), list(paths.values()), table, figure
    )
    comparison = parquet.read(table, COMPARISON).set_index("dataset")
    assert comparison["objects"].to_dict() == {"few": 5, "more": 20}
    assert comparison["coverage"].tolist() == pytest.approx([5 / 2500, 20 / 2500])
    assert comparison["filled_cells"].tolist() == pytest.approx([3 / 625, 10 / 625])
    assert comparison.loc["few", "diversity_min":].tolist() == pytest.approx([0.1, 0.3, 0.2])
    assert [line.split()[0] for line in text.splitlines()[1:4]] == ["few", "more", "published"]
    assert "20 objects, coverage 0.8 %" in figure.read_text()
