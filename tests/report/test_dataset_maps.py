import re
from xml.etree import ElementTree

import pytest

from egad.pipeline.config import Space
from egad.report.data import DatasetReport
from egad.report.dataset_maps import dataset_maps
from egad.report.maps import shown_objects, space_map

SVG = "{http://www.w3.org/2000/svg}"


def drawn(svg: str) -> tuple[list[str], list[list[str]]]:
    """The texts of a figure, and the colours of the squares of each map."""
    root = ElementTree.fromstring(svg)  # noqa: S314
    texts = ["".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")]
    maps = []
    for group in root.iter(f"{SVG}g"):
        if group.get("id", "").startswith("PatchCollection"):
            styles = [path.get("style") or "" for path in group.iter(f"{SVG}path")]
            maps.append([colour for each in styles for colour in re.findall(r"fill: (#\w+)", each)])
    return texts, maps


def test_every_dataset_is_named_and_counted(objects):
    texts, _ = drawn(dataset_maps({"egad": objects, "mine": objects.head(10)}, Space()))
    assert {"egad", "mine", "complexity: simple → complex", "difficulty: easy → hard"} <= set(texts)
    assert "10 objects, coverage 0.4 %" in texts
    assert "objects in a cell" in texts


def test_a_square_for_every_filled_cell_in_the_colour_of_its_count(objects):
    cells = objects.groupby(["complexity_cell", "difficulty_cell"]).size()
    assert cells.max() == 5
    _, (alone,) = drawn(dataset_maps({"egad": objects}, Space()))
    assert len(alone) == len(cells)
    colour_of = dict(zip(cells, alone, strict=True))
    assert [colour_of[count] for count in cells] == alone
    assert len(set(colour_of.values())) == cells.nunique()


def test_the_colour_scale_is_the_same_for_all(objects):
    crowded, sparse = objects.tail(5), objects.head(3)
    _, (first, second) = drawn(dataset_maps({"a": crowded, "b": sparse}, Space()))
    assert set(first) == {"#fde725"}  # the end of viridis
    assert set(second) == {"#440154"}  # its start, for one object a cell


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_any_number_of_datasets_has_a_map_each(objects, count):
    texts, maps = drawn(dataset_maps({f"set{k}": objects for k in range(count)}, Space()))
    assert len(maps) == count
    assert {f"set{k}" for k in range(count)} <= set(texts)


def test_an_empty_dataset_has_an_empty_map(objects):
    texts, maps = drawn(dataset_maps({"none": objects.head(0)}, Space()))
    assert maps in ([], [[]])
    assert "0 objects, coverage 0.0 %" in texts


def test_hard_objects_are_above_and_complex_ones_to_the_right(objects):
    corner = objects.head(2).assign(complexity_cell=[0, 24], difficulty_cell=[0, 24])
    root = ElementTree.fromstring(dataset_maps({"a": corner}, Space()))  # noqa: S314
    group = next(g for g in root.iter(f"{SVG}g") if g.get("id", "").startswith("PatchCollection"))
    starts = [re.match(r"M ([\d.]+) ([\d.]+)", path.get("d")) for path in group.iter(f"{SVG}path")]
    (left, low), (right, high) = [(float(m[1]), float(m[2])) for m in starts]
    assert left < right
    assert low > high  # SVG counts downwards


def test_the_same_objects_give_the_same_bytes_and_no_date(objects):
    svg = dataset_maps({"egad": objects}, Space())
    assert svg == dataset_maps({"egad": objects.copy()}, Space())
    assert "date" not in svg.lower()


def test_the_map_needs_pictures_of_the_objects_that_it_shows_only(objects, pictures):
    shown = shown_objects(objects)
    assert len(shown) < len(objects)
    few = {label: pictures[label] for label in shown}
    tables = {"objects": objects, "rejected": objects[:0]}
    assert space_map(DatasetReport(**tables, pictures=few), Space()) == space_map(
        DatasetReport(**tables, pictures=pictures), Space()
    )
