"""How results print, and what notebooks show of them."""

import base64
import inspect
import io
import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import trimesh
from partial_tables import fill_columns
from PIL import Image

import egad
from egad._util.display import facts_html, table_html
from egad.errors import UserError
from egad.report.drawing import THOUSANDTHS
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad.tables.grasping import GRASPS
from egad.tables.objects import OBJECTS

BOX = trimesh.creation.box((0.03, 0.04, 0.05))
LABELS = ["C03_0", "E08_0", "M14_3"]
PNG = re.compile(r'<img src="data:image/png;base64,([^"]*)"')


class Cells(HTMLParser):
    """The texts of HTML, one after the other."""

    def __init__(self):
        super().__init__()
        self.texts = []

    def handle_data(self, data):
        if data.strip():
            self.texts.append(data.strip())


def shown(result):
    """The texts that a notebook shows of a result."""
    cells = Cells()
    cells.feed(result._repr_html_())
    return cells.texts


def facts(result):
    """The table of facts that a notebook shows, without its title."""
    texts = shown(result)[1:]
    return dict(zip(texts[::2], texts[1::2], strict=True))


def thumbnail(result):
    (content,) = PNG.findall(result._repr_html_())
    return Image.open(io.BytesIO(base64.b64decode(content)))


def attempts(successes, engine="mujoco"):
    """Four attempts at each object."""
    rows = [
        {"label": label, "attempt": number, "success": won, "outcome": ["missed", "success"][won]}
        for label, count in successes.items()
        for number, won in enumerate([True] * count + [False] * (4 - count))
    ]
    return egad.Trials(fill_columns(TRIALS, rows).assign(engine=engine))


@pytest.fixture(scope="module")
def objects():
    return egad.load("released")


@pytest.fixture(scope="module")
def grasps():
    return egad.sample_grasps(BOX, "panda", n=30)


@pytest.fixture(scope="module")
def evolver():
    """A step of evolution, whose candidates were told different measures."""
    evolver = egad.Evolver(seed=0, population=8, cells=5)
    asked = evolver.ask()
    evolver.tell([(1.5 + number, 0.001) for number in range(len(asked))])
    return evolver


def results():
    """The public classes that are no errors and no warnings."""
    found = {name: getattr(egad, name) for name in egad.__all__}
    return [
        name
        for name, value in found.items()
        if inspect.isclass(value) and not issubclass(value, Exception)
    ]


@pytest.mark.parametrize("name", results())
def test_every_result_prints_and_shows_itself(name):
    kind = getattr(egad, name)
    assert kind.__repr__ is not object.__repr__
    assert hasattr(kind, "_repr_svg_" if name == "Picture" else "_repr_html_")


def test_a_picture_is_saved_as_it_is(tmp_path):
    picture = egad.Picture("<svg/>")
    picture.save(tmp_path / "new" / "a.SVG")
    assert (tmp_path / "new" / "a.SVG").read_text() == picture.svg == picture._repr_svg_()
    assert len(repr(picture)) < 100
    assert "save(" in repr(picture)


@pytest.mark.parametrize("path", ["a.png", "a", ".svg", 3, None])
def test_a_picture_is_saved_as_svg_alone(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=r"path is .*; allowed: a"):
        egad.Picture("<svg/>").save(path)
    assert list(tmp_path.iterdir()) == []


def test_names_are_escaped():
    html = facts_html("<b>", {"<script>": "&"})
    assert "&lt;script&gt;" in html
    assert "<script>" not in html
    assert "<script>" not in table_html("", pd.DataFrame({"a": ["<script>"]}))


def test_a_dataset_is_its_measures_by_label(objects):
    few = objects[LABELS]
    assert repr(few) == "Dataset(3 objects)"
    texts = shown(few)
    assert texts[0] == "Dataset(3 objects)"
    assert [text for text in texts if text in LABELS] == LABELS
    assert f"{few.table['complexity'][2]:.4g}" in texts
    assert "..." in shown(objects)


def test_an_object_is_a_thumbnail_with_its_measures(objects):
    each = objects["M14_3"]
    assert repr(each) == "EvolvedObject('M14_3')"
    assert facts(each)["complexity"] == f"{each.row['complexity']:.3f} bit"
    picture = np.asarray(thumbnail(each).convert("RGBA"))
    assert (picture[..., 3] > 0).mean() > 0.2
    assert (picture[..., 3] == 0).any()


def test_an_object_without_its_mesh_says_so(tmp_path):
    table = fill_columns(OBJECTS, [{"id": "d", "label": "D03_0", "complexity": 1.5}])
    parquet.write(table, OBJECTS, tmp_path / "objects.parquet")
    found = facts(egad.load(tmp_path)["D03_0"])
    assert found["complexity"] == "1.500 bit"
    assert "D03_0.obj" in found["mesh"]


def test_an_archive_is_plotted_with_a_picture_of_each_filled_cell(evolver, tmp_path):
    picture = evolver.archive.plot()
    root = ElementTree.fromstring(picture.svg)  # noqa: S314 (our own)
    assert len(root.findall(".//{*}image")) == np.count_nonzero(evolver.archive.counts())
    texts = ["".join(each.itertext()) for each in root.findall(".//{*}text")]
    assert texts[0].startswith(f"{len(evolver.archive)} objects in ")
    assert texts[-2:] == [
        "shape complexity: simple → complex (1 to 5 bit)",
        "grasp difficulty: easy → hard (graspability 4 to 0.5 1e-3)",
    ]
    assert not re.search(r'href="(?!data:)', picture.svg)
    picture.save(tmp_path / "map.svg")
    assert (tmp_path / "map.svg").read_text(encoding="utf-8") == picture.svg


def test_measures_of_ones_own_name_the_axes_of_a_plot(evolver):
    svg = evolver.archive.plot(measures=("bulk", "<length>")).svg
    assert "bulk: low → high (1 to 5)" in svg
    assert "&lt;length&gt;: high → low (0.004 to 0.0005)" in svg
    assert "complexity" not in svg
    for wrong in ("ab", ("bulk",), ("bulk", 3), 5):
        with pytest.raises(UserError, match=r"measures is .*; allowed: two names"):
            evolver.archive.plot(wrong)


def test_grasps_are_plotted_by_collision(grasps):
    free = int(grasps.collision_free.sum())
    for some, blocked in ((grasps, len(grasps) - free), (grasps[grasps.collision_free], 0)):
        svg = some.plot().svg
        for text in (
            f"{free} collision-free",
            f"{blocked} in collision",
            f"robust quality {THOUSANDTHS}",
        ):
            assert f">{text}<" in svg
    with pytest.raises(UserError, match="no grasps to plot"):
        egad.Grasps(parquet.empty(GRASPS)).plot()


def test_a_gripper_prints_what_makes_it_again():
    for hand in (egad.gripper("panda"), egad.Gripper(opening=0.1, pads="bare", palm=(1, 2, 3))):
        again = eval(repr(hand), {"Gripper": egad.Gripper})  # noqa: S307 (our own)
        assert again == hand
    assert repr(egad.Gripper(opening=0.1, pads="bare")) == "Gripper(opening=0.1, pads='bare')"
    found = facts(egad.gripper("panda"))
    assert (found["opening"], found["force"], found["pads"]) == ("0.08", "70.0", "silicone")
    assert "file" not in found


def test_trials_are_plotted_by_object_or_over_the_evaluation_set():
    svg = attempts({"mug": 3, "bar": 1}).plot().svg
    assert all(f">{text}<" in svg for text in ("all 2 objects", "mug", "bar", "missed"))
    assert "all" not in re.findall(r">([^<>]*)</text>", attempts({"mug": 3}).plot().svg)
    grid = attempts({"A0": 4, "B2": 1}).plot().svg
    texts = re.findall(r">([^<>]*)</text>", grid)
    assert {"4/4", "1/4", "difficulty: easy → hard"} <= set(texts)
    assert "C" not in texts
    with pytest.raises(UserError, match="no attempts to plot"):
        egad.Trials(parquet.empty(TRIALS)).plot()


def test_of_many_objects_the_worst_are_plotted():
    many = {f"object-{number:02}": number % 4 for number in range(48)}
    texts = re.findall(r">([^<>]*)</text>", attempts(many).plot().svg)
    names = [text for text in texts if text.startswith("object-")]
    assert len(names) == 30
    assert {many[name] for name in names} == {0, 1, 2}
    assert sum(many[name] == 2 for name in names) == 6
    assert "all 48 objects" in " ".join(texts)


def test_a_comparison_is_in_percentage_points():
    first, second = attempts({"mug": 3, "bar": 3}), attempts({"mug": 1, "bar": 3})
    found = first.compare(second)
    assert repr(found).startswith("Comparison(+25.0 percentage points (95 % interval ")
    assert "8 attempts at 2 objects; test over the objects: p = 1" in repr(found)
    assert "same initial pose" not in repr(found)  # nothing is known of how they began
    assert facts(found)["attempts"] == "8"
    assert "percentage points" in facts(found)["difference"]


def test_what_draws_results_is_loaded_when_it_is_asked_for():
    code = """
import sys, egad
results = [egad.Archive, egad.Dataset, egad.Grasps, egad.Gripper, egad.Measures, egad.Trials]
print([name for name in sys.modules if name.startswith(("egad.report", "matplotlib"))])
sys.modules["matplotlib"] = None  # an extra, which notebooks can do without
assert "force" in egad.gripper("panda")._repr_html_()
"""
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"
