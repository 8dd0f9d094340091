"""Scenes from Python: folders, the card, and mistakes."""

import pandas as pd
import pytest
import trimesh
from PIL import Image
from small_scenes import BOXES

import egad
from egad.errors import UserError
from egad.learning.scenes import making, producing
from egad.tables import parquet
from egad.tables.objects import REJECTED

FEW = {
    "scenes": 3,
    "per_scene": 1.5,
    "seed": 4,
    "grasps": 5,
    "yaws": 2,
    "validation": 0.3,
    "test": 0.3,
    "rule": "none",
}


@pytest.fixture(scope="module")
def flat():
    mesh = trimesh.creation.box([0.03, 0.03, 0.03])
    mesh.vertices[:, 2] = 0
    return mesh


@pytest.fixture(scope="module")
def folder(tmp_path_factory, flat):
    out = tmp_path_factory.mktemp("made") / "scenes"
    egad.make_scenes(BOXES | {"flat": flat}, out=out, **FEW)
    return out


def test_a_folder_holds_scenes_and_their_description(folder):
    names = {path.name for path in folder.iterdir()}
    assert names == {
        "scenes-0.parquet",
        "grasps-0.parquet",
        "card.md",
        "scene.png",
        "rejected.parquet",
    }
    dataset = egad.load_scenes(folder)
    assert list(dataset.index["split"]) == ["train", "validation", "test"]
    rejected = parquet.read(folder / "rejected.parquet", REJECTED)
    assert list(rejected["id"]) == ["flat"]
    with Image.open(folder / "scene.png") as picture:
        assert picture.size == (640, 480)


def test_the_card_counts(folder):
    text = (folder / "card.md").read_text()
    index = egad.load_scenes(folder).index
    lines = {cells[1].strip(): cells for line in text.split("\n") if (cells := line.split("|"))[1:]}
    assert [cell.strip() for cell in lines["scenes"][2:6]] == ["1", "1", "1", "3"]
    assert [cell.strip() for cell in lines["grasps"][2:6]] == ["5", "5", "5", "15"]
    share = f"{100 * index['positive'].sum() / 15:.1f} %"
    assert lines["positive"][5].strip() == share
    none = (index["positive"] == 0).sum()
    assert lines["scenes without a positive grasp"][5].strip() == str(none)
    assert "By object, each of 7 in one split" in text
    assert "- `flat`: " in text
    assert "| `scenes.protocol` | egad |" in text
    assert "left out" not in text


def test_the_same_bytes_on_any_number_of_cores(folder, flat, tmp_path):
    egad.make_scenes(BOXES | {"flat": flat}, out=tmp_path / "again", jobs=2, **FEW)
    for path in folder.iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name


def test_without_a_folder_scenes_last_as_long_as_the_result():
    dataset = egad.make_scenes(BOXES, **FEW | {"scenes": 1, "grasps": 1})
    assert isinstance(dataset, egad.SceneDataset)
    where = dataset.folders[0]
    assert dataset.scene(0).observation([0]).tsdf.weights.any()
    del dataset
    assert not where.exists()


def test_mistakes_are_told(folder, flat):
    for wrong, said in (
        ({"scenes": 0}, "scenes"),
        ({"validation": 0.6, "test": 0.5}, "less than 1"),
        ({"gripper": "cup_30mm"}, "suction cup"),
        ({"protocol": {"noise": ["dex"]}}, "noise of a protocol are not used for labelled"),
        ({"cameras": {"tilt": [60.0, 10.0]}}, "tilt must go from low to high"),
        ({"out": folder}, "is not an empty folder"),
    ):
        with pytest.raises(UserError, match=said):
            egad.make_scenes(BOXES, **FEW | wrong)
    for hold_out, said in (
        (["Box0"], "hold_out has no id of these objects"),
        ([*BOXES], "all 6 objects are held out"),
    ):
        with pytest.raises(UserError, match=said):
            egad.make_scenes(BOXES, hold_out=hold_out, **FEW)
    with pytest.raises(UserError, match="there are no objects"):
        egad.make_scenes({}, **FEW)
    with pytest.raises(UserError, match="none of the objects can be simulated; flat: "):
        egad.make_scenes({"flat": flat}, **FEW)


def test_what_is_held_out_is_in_no_scene(monkeypatch, tmp_path):
    seen = []

    def first(planned, models, settings):
        seen.append(planned.round.ids)
        return making.make_scene(planned, models, settings) if len(seen) == 1 else None

    monkeypatch.setattr(producing, "make_scene", first)
    few = FEW | {"scenes": 30, "grasps": 1, "per_scene": 4.0}
    out = tmp_path / "scenes"
    egad.make_scenes(BOXES, hold_out=pd.Series(["box1", "box4", "other"]), out=out, **few)
    assert {name for ids in seen for name in ids} == {"box0", "box2", "box3", "box5"}
    text = (out / "card.md").read_text()
    assert "2 objects are in no scene: those held out, with their parents and children." in text


def test_scenes_that_cannot_be_simulated_are_left_out(monkeypatch, tmp_path):
    def some(planned, models, settings):
        return None if planned.round.number != 1 else making.make_scene(planned, models, settings)

    monkeypatch.setattr(producing, "make_scene", some)
    dataset = egad.make_scenes(BOXES, out=tmp_path / "some", **FEW)
    assert list(dataset.index["scene"]) == [1]
    assert "2 of 3 planned scenes are left out" in (tmp_path / "some/card.md").read_text()
    monkeypatch.setattr(producing, "make_scene", lambda *_, **__: None)
    with pytest.raises(UserError, match="no scene could be made"):
        egad.make_scenes(BOXES, **FEW)
