"""The gallery of the objects of `conftest`: its data say what the tables say."""

import io
import json
import re

import numpy as np
import pandas as pd
import pytest
import trimesh
from PIL import Image

from egad.evolution import Lineage
from egad.grippers import GRIPPERS
from egad.report.axes import USUAL
from egad.report.gallery import details, files
from egad.report.gallery.files import data_script, file_link
from egad.report.gallery.index import index_data
from egad.report.gallery.page import GalleryData, gallery_page
from egad.report.viewer import LABELS, label_codes

HOSTILE = "</script><script>alert(1)</script>"
NETWORK = details.GenomeText("<svg/>", "output = x")
MESH = trimesh.creation.box([0.03, 0.04, 0.05])


def read(script: str) -> tuple[str, dict]:
    """Name and data of a script, by a parser of JSON."""
    found = re.fullmatch(r"egadData\((.*)\);\n", script)
    assert found
    name, data = json.loads(f"[{found[1]}]")
    return name, data


@pytest.fixture(scope="module")
def lineage(objects) -> Lineage:
    """Every object descends from the one before; the first from `lost` and `gone`, not released."""
    ids = objects["id"].tolist()
    parents = [[], ["lost"], ["gone", "lost"], *([each] for each in ids[:-2])]
    names = ["lost", "gone", *ids[:-1]]
    table = pd.DataFrame({"id": names, "parents": parents})
    measures = {
        "complexity": 1.5,
        "graspability": 0.002,
        "graspability_std": 0.0,
        "cell_confidence": 1,
    }
    return Lineage(table.assign(**measures, epoch=0, island=1, step=2))


@pytest.fixture(scope="module")
def simulated(grasps, objects) -> pd.DataFrame:
    """The collision-free grasps were simulated, but the first one crashed; every second held."""
    free = grasps["collision_free"].to_numpy()
    held = pd.Series(np.where(free, np.arange(len(grasps)) % 8 == 0, None), dtype=object)
    held[0] = None
    ids = dict(zip(objects["label"], objects["id"], strict=True))
    return grasps.assign(
        id=grasps["label"].map(ids),
        simulated_success=held,
        simulated_outcome="success",
        simulated_engine="mujoco",
    )


@pytest.fixture(scope="module")
def data(objects, simulated, evalset, trials, lineage) -> GalleryData:
    factors = dict.fromkeys(objects["label"][1:], 0.5)
    return GalleryData(
        objects,
        gripper="egad_75mm",
        factors=factors,
        grasps=simulated,
        evaluation=evalset.assign(id=objects["id"].iloc[[3, 7, 20]].to_numpy()),
        trials={"antipodal": trials},
        lineage=lineage,
    )


def page_of(data: GalleryData, number: int) -> dict:
    return details.object_data(data.page(data.objects.iloc[number]), MESH, None, USUAL)


def fact(page: dict, name: str) -> list:
    return next(each for each in page["facts"] if each[0] == name)[1:]


def test_the_index_has_the_numbers_of_the_table(data, objects, settings, simulated):
    index = index_data(objects, settings.space, USUAL, data.member, GRIPPERS["egad_75mm"])
    name, index = read(data_script("index", index))
    assert name == "index"
    columns = index["columns"]
    for ours, theirs in {"label": "label", "id": "id", "column": "complexity_cell"}.items():
        assert columns[ours] == objects[theirs].tolist()
    for name in ("complexity", "graspability", "diversity"):
        np.testing.assert_allclose(columns[name], objects[name], rtol=1e-5)
    np.testing.assert_allclose(columns["error"], objects["graspability_std"], rtol=1e-5)
    known = simulated[simulated["simulated_success"].notna()]
    share = known["simulated_success"].astype(float).groupby(known["id"]).mean()
    for each, value in zip(columns["id"], columns["simulated"], strict=True):
        assert value == (pytest.approx(share[each], rel=1e-5) if each in share else None)
    assert [each for each in columns["place"] if each] == ["A0", "C4", "G6"]
    assert columns["family"][:-1] == ["lost"] * 39
    assert columns["family"][-1] == ""


def test_no_two_objects_share_a_place_on_a_sheet(data, objects, settings):
    index = index_data(objects, settings.space, USUAL, data.member)
    columns = index["columns"]
    places = list(zip(columns["rank"], columns["column"], columns["row"], strict=True))
    assert len(set(places)) == len(objects)
    assert max(columns["rank"]) + 1 == len(index["sheets"]) == 5
    top = objects.assign(rank=columns["rank"]).query("rank == 0")
    best = objects.groupby(["complexity_cell", "difficulty_cell"])["diversity"].max()
    assert sorted(top["diversity"]) == sorted(best)


def test_pictures_lie_where_the_page_looks_for_them():
    tones = {(0, 0): 40, (2, 1): 200}
    shape = (files.TILE, files.TILE, 4)
    pictures = {at: np.full(shape, [tone] * 3 + [255], np.uint8) for at, tone in tones.items()}
    content = files.sheet(pictures, 3, 2)
    assert content == files.sheet(dict(reversed(pictures.items())), 3, 2)
    image = np.asarray(Image.open(io.BytesIO(content)).convert("RGBA")).astype(int)
    assert image.shape == (2 * files.TILE, 3 * files.TILE, 4)
    middle = image[files.TILE // 2 :: files.TILE, files.TILE // 2 :: files.TILE]
    assert (middle[..., 3] > 0).sum() == 2
    for (column, row), tone in tones.items():
        assert middle[row, column] == pytest.approx([tone] * 3 + [255], abs=3)


def test_ancestors_fill_sheets_in_the_order_of_their_numbers():
    picture = np.full((files.TILE, files.TILE, 4), 255, np.uint8)
    numbers = [0, files.COLUMNS, files.PER_SHEET + 1]
    found = list(files.ancestor_sheets(dict.fromkeys(numbers, picture), files.PER_SHEET + 2))
    images = [np.asarray(Image.open(io.BytesIO(each)).convert("RGBA")) for each in found]
    shown = [image[:: files.TILE, :: files.TILE, 3].ravel().nonzero()[0] for image in images]
    assert [each.tolist() for each in shown] == [[0, files.COLUMNS], [1]]


def test_the_page_of_an_object_has_the_numbers_of_the_tables(data, objects, simulated):
    label, row = objects["label"].iloc[3], objects.iloc[3]
    _, page = read(data_script(f"objects/{label}", page_of(data, 3)))
    assert fact(page, "complexity")[0] == pytest.approx(row["complexity"], rel=1e-5)
    value, error, *_ = fact(page, "graspability")
    assert value == pytest.approx(1000 * row["graspability"], rel=1e-5)
    assert error == pytest.approx(1000 * row["graspability_std"], rel=1e-5)
    own = simulated[simulated["label"] == label]
    codes = [LABELS[code] for code in label_codes(own)]
    assert page["labels"] == [codes.count(name) for name in LABELS]
    assert sum(page["labels"]) == page["scene"]["counts"][2] == len(own)
    held, failed = page["labels"][1], page["labels"][2]
    share, error, *_ = fact(page, "antipodal success")
    assert share == pytest.approx(100 * held / (held + failed))
    assert error > 0
    [[detector, successes, attempts, low, high]] = page["trials"]
    assert (detector, successes, attempts) == ("antipodal", 15, 20)
    assert low < 0.75 < high


@pytest.mark.parametrize(("held", "failed"), [(4, 0), (3, 17), (0, 9)])
def test_the_error_of_simulated_success_is_that_of_an_interval_by_wilson(data, held, failed):
    table = data.grasps[data.grasps["label"] == data.objects["label"].iloc[6]]
    success = [True] * held + [False] * failed
    rows = table.sample(held + failed, replace=True, random_state=0, ignore_index=True)
    tried = rows.assign(collision_free=True, simulated_success=success)
    page = details.object_data(details.ObjectPage(data.objects.iloc[6], tried), MESH, None, USUAL)
    count = held + failed
    share = held / count
    half = np.sqrt(share * (1 - share) / count + 1 / (4 * count**2)) / (1 + 1 / count)  # z = 1
    assert fact(page, "antipodal success")[1] == pytest.approx(100 * half, rel=1e-5)


def test_sizes_are_those_of_the_scaled_object(objects, data):
    row = objects.iloc[5].copy()
    row[["extents_x", "extents_y", "extents_z"]] = 0.1, 0.05, 0.02
    row[["mass", "volume", "area"]] = 0.4, 1e-4, 0.01
    page = details.object_data(data.page(row), MESH, None, USUAL)
    assert fact(page, "size")[0] == "50 \N{MULTIPLICATION SIGN} 25 \N{MULTIPLICATION SIGN} 10"
    assert fact(page, "mass")[0] == pytest.approx(50)
    assert fact(page, "volume")[0] == pytest.approx(12.5)
    assert fact(page, "surface")[0] == pytest.approx(25)


def test_the_way_back_to_the_first_generation_needs_nothing_but_links(data, objects):
    ids = dict(zip(objects["label"], objects["id"], strict=True))
    page, steps = page_of(data, 2), 0
    while page["relatives"]["parents"]:
        first = page["relatives"]["parents"][0]
        if isinstance(first, str):
            page = page_of(data, int(np.flatnonzero(objects["label"] == first)[0]))
            assert page["id"] == ids[first]
        else:
            row = data.ancestors.iloc[first[1]]
            page = details.ancestor_data(row, None, NETWORK, data.relatives(row["id"]), USUAL)
            assert page["id"] == row["id"] == first[0]
        steps += 1
    assert (page["id"], steps) == ("lost", 4)
    assert page["relatives"]["children"] == [["gone", 1], objects["label"].iloc[0]]


def test_what_is_missing_is_left_out(objects, settings):
    bare = objects.assign(graspability_std=np.nan, cell_confidence=np.nan, mass=np.nan)
    data = GalleryData(bare)
    index = index_data(bare, settings.space, USUAL, data.member)
    assert set(index["columns"]["error"]) == {None}
    assert "simulated" not in index["columns"]
    _, page = read(data_script("x", page_of(data, 0)))
    assert fact(page, "graspability")[1] is None
    assert "mass" not in {name for name, *_ in page["facts"]}
    assert page["labels"] is page["relatives"] is page["genome"] is None
    assert page["trials"] == page["links"] == []
    assert page["scene"]["counts"][2] == 0


def test_objects_without_grasps_say_why(data):
    assert "cannot be scaled" in page_of(data, 0)["note"]
    label = data.objects["label"].iloc[4]
    none = data.grasps[data.grasps["label"] != label]
    without = GalleryData(data.objects, data.gripper, data.factors, none)
    assert page_of(without, 4)["note"]
    assert page_of(without, 5)["note"] == ""


def test_names_from_tables_are_escaped(data, objects):
    script = data_script("objects/" + HOSTILE, {"id": HOSTILE + "\u2028'\\"})
    assert script.isascii()
    assert read(script) == ("objects/" + HOSTILE, {"id": HOSTILE + "\u2028'\\"})
    links = [details.Download(HOSTILE, "x.md")]
    html = gallery_page(HOSTILE, GalleryData(objects, HOSTILE, grasps=data.grasps), USUAL, links)
    assert "<script>alert" not in html
    assert file_link("meshes", "a#b?c%.glb") == "meshes/a%23b%3Fc%25.glb"


def test_the_page_loads_nothing_from_elsewhere(data):
    html = gallery_page("EGAD", data, USUAL, [])
    assert not re.search(r"https?:|//cdn|@import|\bfetch\(|\bimport ", html)
