import re
from xml.etree import ElementTree

import numpy as np
import pytest
from svg_text import SVG, texts

from egad.measures import MeasureSpace
from egad.report.comparison import comparison_text, dataset_maps


def colors(svg: str) -> list[list[str]]:
    """The colors of the squares of each map."""
    root = ElementTree.fromstring(svg)  # noqa: S314
    maps = []
    for group in root.iter(f"{SVG}g"):
        if group.get("id", "").startswith("PatchCollection"):
            styles = [path.get("style") or "" for path in group.iter(f"{SVG}path")]
            maps.append([color for each in styles for color in re.findall(r"fill: (#\w+)", each)])
    return maps


def test_every_dataset_is_named_and_counted(objects):
    shown = texts(dataset_maps({"egad": objects, "mine": objects.head(10)}, MeasureSpace()))
    assert {"egad", "mine", "complexity: simple → complex", "difficulty: easy → hard"} <= set(shown)
    assert "10 objects, coverage 0.4 %" in shown
    assert "objects in a cell" in shown


def test_a_square_for_every_filled_cell_in_the_color_of_its_count(objects):
    cells = objects.groupby(["complexity_cell", "difficulty_cell"]).size()
    assert cells.max() == 5
    (alone,) = colors(dataset_maps({"egad": objects}, MeasureSpace()))
    assert len(alone) == len(cells)
    color_of = dict(zip(cells, alone, strict=True))
    assert [color_of[count] for count in cells] == alone
    assert len(set(color_of.values())) == cells.nunique()


def test_the_color_scale_is_the_same_for_all(objects):
    crowded, sparse = objects.tail(5), objects.head(3)
    first, second = colors(dataset_maps({"a": crowded, "b": sparse}, MeasureSpace()))
    assert set(first) == {"#fde725"}  # the end of viridis
    assert set(second) == {"#440154"}  # its start, for one object a cell


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_any_number_of_datasets_has_a_map_each(objects, count):
    svg = dataset_maps({f"set{k}": objects for k in range(count)}, MeasureSpace())
    assert len(colors(svg)) == count
    assert {f"set{k}" for k in range(count)} <= set(texts(svg))


def test_an_empty_dataset_has_an_empty_map(objects):
    svg = dataset_maps({"none": objects.head(0)}, MeasureSpace())
    assert colors(svg) in ([], [[]])
    assert "0 objects, coverage 0.0 %" in texts(svg)


def test_hard_objects_are_above_and_complex_ones_to_the_right(objects):
    corner = objects.head(2).assign(complexity_cell=[0, 24], difficulty_cell=[0, 24])
    root = ElementTree.fromstring(dataset_maps({"a": corner}, MeasureSpace()))  # noqa: S314
    group = next(g for g in root.iter(f"{SVG}g") if g.get("id", "").startswith("PatchCollection"))
    starts = [re.match(r"M ([\d.]+) ([\d.]+)", path.get("d")) for path in group.iter(f"{SVG}path")]
    (left, low), (right, high) = [(float(m[1]), float(m[2])) for m in starts]
    assert left < right
    assert low > high  # SVG counts downwards


def test_the_same_objects_give_the_same_bytes_and_no_date(objects):
    svg = dataset_maps({"egad": objects}, MeasureSpace())
    assert svg == dataset_maps({"egad": objects.copy()}, MeasureSpace())
    assert "date" not in svg.lower()


@pytest.mark.parametrize("rows", [0, 2])
def test_rows_in_which_no_object_is_expected_are_hatched(objects, rows):
    svg = dataset_maps({"egad": objects}, MeasureSpace(), unattainable=rows)
    root = ElementTree.fromstring(svg)  # noqa: S314
    assert len(list(root.iter(f"{SVG}pattern"))) == bool(rows)


def test_the_table_for_a_terminal_has_ours_above_the_published(report):
    comparison = report.comparison.assign(diversity_max=[0.3, np.nan])
    head, egad, mine, published, *theirs = comparison_text(comparison).splitlines()
    measures = ["coverage", "attainable", "diversity:", "min", "max", "mean"]
    assert head.split() == ["dataset", "objects", *measures]
    assert egad.split() == ["egad", "40", "1.6", "%", "1.7", "%", "0.10", "0.30", "0.20"]
    assert mine.split() == ["mine", "12", "0.5", "%", "0.5", "%", "0.12", "-", "0.21"]
    assert published == "published"
    assert theirs[1].split() == ["YCB", "78", "3", "%", "-", "0.11", "0.65", "0.19"]
    assert len({len(line) for line in (head, egad, mine, *theirs)}) == 1
