"""Images of a whole dataset: any shards, held-out objects, what is left out, and the card."""

import json

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.errors import UserError
from egad.exchange.meshes import write_obj
from egad.perception.image_shards import read
from egad.perception.parameters import RenderParameters
from egad.pipeline.cli import main
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select
from egad.pipeline.stages import image_card, render
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import GRASPS, SCALES
from egad.tables.objects import OBJECTS, REJECTED

WHOLE = Settings.model_validate({"render": {"images": 40, "test": 0.2, "validation": 0.2}})
SETTINGS = select(WHOLE, RenderParameters, "egad_75mm")
NAMES = [f"B{number}" for number in range(8)]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Blocks with a grasp that is free and a narrow one, for which the fingers stand in the block.

    But B5 has the latter only, B6 none, and the mesh of B7 is flat.
    """
    folder = tmp_path_factory.mktemp("results") / "mine"
    meshes = folder / "rescaled" / "egad_75mm"
    grasps = []
    for number, name in enumerate(NAMES):
        sides = np.array([0.03 + 0.002 * number, 0.05, 0.04])
        mesh = trimesh.creation.box(sides)
        if name == "B7":
            mesh.vertices[:, 2] = 0
        write_obj(mesh, meshes / f"{name}.obj")
        base = dict.fromkeys(GRASPS.names, 0) | {"id": f"id-{name}", "label": name}
        base |= {"axis_x": 1.0, "robust_quality": 0.001 * number}
        widths = {"B5": [0.01], "B6": []}.get(name, [sides[0], 0.01])
        grasps += [base | {"grasp": n, "width": width} for n, width in enumerate(widths)]
    parquet.write(pd.DataFrame(grasps), GRASPS, folder / "grasps.parquet")
    rows = [dict.fromkeys(OBJECTS.names, 0) | {"id": f"id-{n}", "label": n} for n in NAMES]
    objects = pd.DataFrame(rows)[OBJECTS.names].assign(complexity=np.arange(8.0))
    parquet.write(objects, OBJECTS, folder / "objects.parquet")
    scales = pd.DataFrame([dict.fromkeys(SCALES.names, 0) | {"label": n, "file": n} for n in NAMES])
    parquet.write(scales.assign(rule="paper"), SCALES, meshes / "scales.parquet")
    chosen = [dict.fromkeys(EVAL49.names, 0) | {"label": "A0", "id": "id-B1", "object_label": "B1"}]
    parquet.write(pd.DataFrame(chosen), EVAL49, folder / "eval49.parquet")
    return folder


def paths(dataset):
    meshes = dataset / "rescaled" / "egad_75mm"
    return dataset / "objects.parquet", meshes, dataset / "grasps.parquet"


def made(dataset, out, shards=1, settings=SETTINGS, held_out=True):
    evaluation = dataset / "eval49.parquet" if held_out else None
    for number in range(shards):
        files = (out / f"images-{number}.parquet", out / f"rejected-{number}")
        render.run(settings, *paths(dataset), (number, shards), *files, evaluation)
    return read(out)


@pytest.fixture(scope="module")
def images(dataset):
    return made(dataset, dataset / "images")


def test_every_object_has_its_images_in_one_split(dataset, images):
    table = images.table
    planned = render.planned(SETTINGS, *paths(dataset)[:2], dataset / "eval49.parquet")
    counts = {share.id: share.images for share in planned if share.label != "B7"}
    assert table.groupby("id").size().to_dict() == counts
    assert sum(share.images for share in planned) == 40
    assert table.groupby("id")["split"].nunique().max() == 1
    assert table["image"].is_monotonic_increasing
    assert set(table.loc[table["label"] == "B1", "split"]) == {"test"}
    assert table.groupby("id")["pose"].is_monotonic_increasing.all()


def test_any_number_of_shards_gives_the_same_images(dataset, images, tmp_path):
    pd.testing.assert_frame_equal(made(dataset, tmp_path, 5).table, images.table)


def test_objects_without_a_pose_are_left_out_and_without_grasps_are_not(dataset, images):
    assert "id-B7" not in set(images.table["id"])
    left_out = parquet.read(dataset / "images" / "rejected-0", REJECTED)
    assert left_out["id"].tolist() == ["id-B7"]
    assert left_out["stage"].tolist() == ["render"]
    assert left_out["reason"].iloc[0]
    bare = images.table[images.table["label"] == "B6"]
    assert len(bare)
    assert not bare["grasp"].map(len).any()


def test_images_depend_on_their_object_alone(dataset, images, tmp_path):
    """With other splits an object has other numbers, and in each pose the same first views."""
    whole = Settings.model_validate({"render": {"images": 90, "hold_out": False}})
    settings = select(whole, RenderParameters, "egad_75mm")
    other = made(dataset, tmp_path, 1, settings, held_out=False).table
    assert not other.groupby("id").size().equals(images.table.groupby("id").size())
    compared = 0
    for key, rows in other.groupby(["label", "pose"]):
        before = images.table[(images.table[["label", "pose"]] == list(key)).all(axis=1)]
        count = min(len(before), len(rows))
        assert before["depth"].tolist()[:count] == rows["depth"].tolist()[:count]
        compared += count
    assert compared > 20


@pytest.mark.parametrize("held_out", [True, False])
def test_holding_out_needs_the_evaluation_set_and_nothing_else_does(dataset, tmp_path, held_out):
    whole = Settings.model_validate({"render": {"hold_out": not held_out}})
    settings = select(whole, RenderParameters, "egad_75mm")
    with pytest.raises(UserError, match="hold_out is"):
        made(dataset, tmp_path, 1, settings, held_out)


def test_the_card_counts_what_is_there(dataset, images, tmp_path):
    rejected = [dataset / "images" / "rejected-0"]
    out = tmp_path / "card.md"
    given = (dataset / "images", 1, rejected, out, tmp_path / "r.parquet")
    image_card.run(SETTINGS, "mine", "egad_75mm", *given)
    text = out.read_text()
    grasps = [picture.grasps for picture in images]
    free = sum(int(each.collision_free.sum()) for each in grasps)
    reachable = sum(len(each.collision_free) for each in grasps)
    bare = sum(len(each.collision_free) == 0 for each in grasps)
    empty = sum(not each.collision_free.any() for each in grasps)
    assert 0 < free < reachable
    assert 0 < bare < empty
    for title, number in (
        ("objects", 7),
        ("images", len(images)),
        ("images without a reachable grasp", bare),
        ("images without a free grasp", empty),
        ("reachable grasps", reachable),
        ("free grasps", free),
    ):
        line = next(line for line in text.splitlines() if line.startswith(f"| {title} |"))
        cells = [int(cell) for cell in line.split("|")[2:-1]]
        assert cells[-1] == sum(cells[:-1]) == number
    assert "`id-B7`" in text
    assert len(parquet.read(tmp_path / "r.parquet", REJECTED)) == 1


def test_leftovers_of_a_larger_set_are_removed(dataset, tmp_path):
    made(dataset, tmp_path, 3)
    made_again = tmp_path / "images-0.parquet"
    with pytest.raises(UserError, match="expected images in 1 shards"):
        image_card.tidy(tmp_path, 1)
    assert len(list(tmp_path.glob("images-*"))) == 3
    evaluation = dataset / "eval49.parquet"
    render.run(SETTINGS, *paths(dataset), (0, 1), made_again, tmp_path / "r", evaluation)
    assert image_card.tidy(tmp_path, 1) == [made_again]
    assert sorted(path.name for path in tmp_path.glob("images-*")) == ["images-0.parquet"]


def test_the_commands_do_the_same(dataset, images, tmp_path, monkeypatch):
    objects, meshes, grasps = map(str, paths(dataset))
    text = json.dumps(SETTINGS.model_dump(mode="json"))
    out, rejected = tmp_path / "images-0.parquet", tmp_path / "rejected"
    given = ["--settings", text, "--shards", "1", "--rejected", str(rejected)]
    options = ["--objects", objects, "--meshes", meshes, "--grasps", grasps]
    evaluation = ["--eval", str(dataset / "eval49.parquet"), "--shard", "0", "--out", str(out)]
    run(monkeypatch, "render", *given, *options, *evaluation)
    pd.testing.assert_frame_equal(read(tmp_path).table, images.table)
    card, table = tmp_path / "card.md", str(tmp_path / "rejected.parquet")
    names = ["--dataset", "mine", "--gripper", "egad_75mm", "--images", str(tmp_path)]
    given = ["--settings", text, "--shards", "1", "--rejected", table, "--out", str(card)]
    run(monkeypatch, "image-card", *given, *names, "--rejects", str(rejected))
    assert card.read_text().startswith("# Depth images of mine for egad_75mm")


def run(monkeypatch, *arguments):
    monkeypatch.setattr("sys.argv", ["egad", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None)
