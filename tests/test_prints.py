"""How results print, and what notebooks show of them."""

import base64
import inspect
import io
import math
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
from egad.tables.clutter import CLUTTER
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


def test_a_long_table_is_cut_and_a_long_text_is_not():
    text = 200 * "x"
    html = table_html("Letters", pd.DataFrame({"a": [text, *range(98), "last"]}))
    assert text in html
    assert "last" in html
    assert html.count("<tr") == 12  # with a heading and a row of dots


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


def test_an_archive_is_its_numbers(evolver):
    archive, count = evolver.archive, len(evolver.archive)
    found = facts(archive)
    assert found["elites"] == str(count)
    assert found["coverage"] == f"{100 * count / 100:.1f} %"  # 25 cells of 4
    assert found["filled cells"] == f"{np.count_nonzero(archive.counts())} of 25"
    assert found["range of the second measure"] == "0.0005 to 0.004"
    assert repr(evolver) == f"Evolver({archive!r})"
    assert facts(evolver) == found
    assert re.fullmatch(
        r"Elite\('\w{12}': complexity [\d.]+, graspability 0.001\)", repr(archive.elites[0])
    )


def test_a_candidate_is_a_thumbnail(evolver):
    each = evolver.ask()[0]
    assert repr(each) == f"Candidate('{each.id}')"
    assert facts(each) == {"solid voxels": str(each.voxels.sum()), "resolution": "25"}
    assert thumbnail(each).size == (320, 320)


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


def test_an_empty_archive_is_an_empty_map():
    svg = egad.Evolver(cells=5).archive.plot().svg
    assert "0 objects in 0 of 25 cells, coverage 0.0 %" in svg
    assert "<image" not in svg


def test_a_lineage_tells_its_founders(objects):
    found = re.fullmatch(r"Lineage\((\d+) objects, (\d+) of them founders\)", repr(objects.lineage))
    table = objects.lineage.table
    assert int(found[1]) == len(objects.lineage) == len(table)
    assert int(found[2]) == sum(len(each) == 0 for each in table["parents"])
    assert table["id"].iloc[0] in shown(objects.lineage)


def test_grasps_tell_how_many_are_usable(grasps):
    free, holding = grasps.collision_free.sum(), (grasps.quality > 0).sum()
    low, high = 1000 * grasps.widths.min(), 1000 * grasps.widths.max()
    assert repr(grasps) == (
        f"Grasps({len(grasps)} grasps, collision-free: {free}, without slip: {holding}, "
        f"widths: {low:.1f} to {high:.1f} mm, best quality: {grasps.quality.max():.3g})"
    )
    assert facts(grasps)["collision-free"] == str(free)
    assert repr(grasps[0]).startswith("Grasps(1 grasp, ")
    assert repr(grasps[[]]) == "Grasps(0 grasps)"
    assert facts(grasps[[]]) == {"grasps": "0"}


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


def test_stable_poses_print_their_probability():
    first = egad.stable_poses(trimesh.creation.box((1, 1, 4)))[0]
    assert repr(first).startswith(f"StablePose(probability {100 * first.probability:.1f} %, ")
    assert facts(first) == {
        "probability": f"{100 * first.probability:.1f} %",
        "center of mass at height": "0.5",
        "topples at": f"{math.degrees(math.atan(1)):.1f}°",
        "corners of the resting face": "4",
    }


def test_a_repaired_mesh_tells_what_was_done():
    assert repr(egad.repair(BOX)) == "Repaired(12 faces, unchanged)"
    beside = BOX.copy().apply_translation((1, 0, 0)).apply_scale(0.5)
    found = egad.repair(trimesh.util.concatenate([BOX, beside]))
    assert repr(found) == f"Repaired(12 faces, changed, {found.dropped})"
    assert facts(found)["left out"] == found.dropped
    assert thumbnail(found).size == (320, 320)
    sheet = egad.repair(trimesh.Trimesh(BOX.vertices, BOX.faces[:2]), "thicken", 0.003)
    assert "3 mm thick" in repr(sheet)


def test_measures_are_a_table_with_what_they_hold_for():
    found = egad.measure(BOX, gripper="panda", rule="none", max_candidates=512)
    table = facts(found)
    assert shown(found)[0] == found.label
    assert table["complexity"] == f"{found.complexity:.3f} bit (0.000 by its triangles)"
    assert table["grasped by"] == "a gripper (panda, opening 80 mm)"
    assert table["not comparable with the map"] == "(exact, yumi)"


def test_trials_are_rates_by_object():
    trials = attempts({"mug": 3, "bar": 1})
    assert repr(trials).startswith("Trials in mujoco: 50.0 % (95 % interval ")
    texts = shown(trials)
    assert texts[0] == repr(trials)
    assert texts[-8:] == ["bar", "1", "4", "0.25", "mug", "3", "4", "0.75"]
    rate = trials.success_rate()
    assert shown(rate) == [repr(rate)]


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


def test_comparisons_of_attempts_that_began_alike_have_both_tests():
    tables = [attempts({"mug": count}).table.assign(id="m", initial_pose="p") for count in (3, 1)]
    found = egad.Trials(tables[0]).compare(egad.Trials(tables[1]))
    assert "(no interval)" in repr(found)
    assert repr(found).endswith(
        "p = 0.5, of 4 only the first succeeded in 2, only the second in 0)"
    )


def test_a_benchmark_prints_the_rates_of_each_kind_of_scene():
    rows = [
        {"scene": scene, "noise": "none", "round": number, "n_objects": 2, "success": won}
        for scene, won in (("pile", True), ("packed", False))
        for number in range(3)
    ]
    table = fill_columns(CLUTTER, rows).assign(engine="mujoco", id="a", outcome="missed")
    benchmark = egad.Benchmark(table)
    title, *lines = repr(benchmark).splitlines()
    assert title == "Benchmark in mujoco: 6 attempts"
    for line, rate in zip(lines, benchmark.rates(), strict=True):
        assert line.startswith(f"{rate.scene}, noise none, 3 rounds: success {rate.success}; ")
    texts = shown(benchmark)
    assert texts[0] == title
    assert {"pile", "packed", repr(benchmark.rates()[0].cleared)} <= set(texts)


def test_an_export_tells_what_was_left_out(tmp_path):
    found = egad.Exported(tmp_path, ["mug", "bar"], {"sheet": "it is open"})
    assert shown(found)[0] == str(tmp_path)
    assert facts(found) == {"exported": "2", "left out: sheet": "it is open"}


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
