"""Labelled scenes of a whole dataset: any shards, what is held out and left out, and the card."""

import numpy as np
import pandas as pd
import pytest
import scene_card
import scenes
import trimesh

from egad.errors import UserError
from egad.io import write_obj
from egad.learning.scenes import MakeScenes, SceneParameters, load_scenes
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS, EVAL49
from egad.tables.evolution import LINEAGE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.settings import Settings, select

FEW = {"scenes": 4, "objects": 1.5, "grasps": 3, "yaws": 2, "validation": 0.25, "test": 0.25}
NAMES = [f"B{number}" for number in range(8)]
# B0 to B3 are a family, B4 and B5, B6 and B7
PARENTS = {"B1": "B0", "B2": "B0", "B3": "B2", "B5": "B4", "B7": "B6"}


def settings_of(stage=MakeScenes, **changes):
    whole = Settings.model_validate({"scenes": FEW | changes})
    return select(whole, stage, "panda")


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Blocks; but B3 could not be scaled, and B2 has no convex parts."""
    folder = tmp_path_factory.mktemp("results") / "mine"
    meshes, parts, scaled = folder / "rescaled" / "panda", [], []
    for number, name in enumerate(NAMES):
        mesh = trimesh.creation.box(np.array([0.03 + 0.002 * number, 0.05, 0.06]))
        if name != "B3":
            write_obj(mesh, meshes / f"{name}.obj")
            scaled.append(dict.fromkeys(SCALES.names, 0) | {"label": name, "file": name})
        if name not in ("B2", "B3"):
            part = {"vertices": mesh.vertices.ravel(), "faces": mesh.faces.ravel()}
            base = dict.fromkeys(CONVEX_PARTS.names, 0) | {"within": True}
            parts.append(base | {"id": f"id-{name}", "label": name, **part})
    parquet.write(pd.DataFrame(parts), CONVEX_PARTS, folder / "parts.parquet")
    rows = [dict.fromkeys(OBJECTS.names, 0) | {"id": f"id-{n}", "label": n} for n in NAMES]
    parquet.write(pd.DataFrame(rows), OBJECTS, folder / "objects.parquet")
    table = pd.DataFrame(scaled).assign(rule="paper")
    parquet.write(table, SCALES, meshes / "scales.parquet")
    chosen = [dict.fromkeys(EVAL49.names, 0) | {"label": "A0", "id": "id-B6", "object_label": "B6"}]
    parquet.write(pd.DataFrame(chosen), EVAL49, folder / "eval49.parquet")
    born = [
        {name: 0 if "list" not in str(LINEAGE.field(name).type) else [] for name in LINEAGE.names}
        | {"id": f"id-{name}", "parents": [f"id-{PARENTS[name]}"] if name in PARENTS else []}
        for name in NAMES
    ]
    parquet.write(pd.DataFrame(born), LINEAGE, folder / "ancestry.parquet")
    return folder


def files_of(dataset, held_out=True, ancestry=True):
    return {
        "objects": dataset / "objects.parquet",
        "scales": dataset / "rescaled/panda/scales.parquet",
        "convex_parts": dataset / "parts.parquet",
        "evaluation": dataset / "eval49.parquet" if held_out else None,
        "ancestry": dataset / "ancestry.parquet" if ancestry else None,
    }


def made(dataset, out, order=(0,), changes=(), **given):
    settings, meshes = settings_of(**dict(changes)), dataset / "rescaled/panda"
    for number in order:
        paths = {
            name: out / f"{file}-{number}.parquet"
            for name, file in (("out", "scenes"), ("grasps", "grasps"))
        }
        shard = (number, len(order))
        scenes.run(
            settings, "panda", meshes=meshes, shard=shard, **files_of(dataset, **given), **paths
        )
    scene_card.run(
        settings_of(SceneParameters, **dict(changes)),
        "mine",
        "panda",
        out,
        len(order),
        **files_of(dataset, **given),
    )
    return load_scenes(out)


@pytest.fixture(scope="module")
def whole(dataset):
    return made(dataset, dataset / "scenes")


def test_objects_are_of_one_split_by_family(whole):
    index = whole.index
    assert list(index["split"]) == ["train", "train", "validation"]  # none is left to test
    families = {"train": {"id-B0", "id-B1"}, "validation": {"id-B4", "id-B5"}}
    for _, row in index.iterrows():
        assert set(row["objects"]) <= families[row["split"]]


def test_what_is_left_out_is_told(dataset, whole):
    assert len(whole) == 3
    assert (whole.gripper_name, whole.gripper) == ("panda", settings_of().gripper)
    folder = dataset / "scenes"
    rejected = parquet.read(folder / "rejected.parquet", REJECTED).set_index("id")["reason"]
    assert rejected.to_dict() == {
        "id-B2": "it has no convex parts for the simulation",
        "id-B3": "it could not be scaled to the gripper",
    }
    text = (folder / "card.md").read_text()
    assert text.startswith("# Labelled scenes of mine for panda\n")
    assert "2 objects are in no scene: the evaluation set with its parents and children" in text
    assert "the 6 objects have 2 founders" in text
    assert "for training, until it has 50 % of the objects." in text
    assert "| `scenes.grasps` | " in text
    assert "- `id-B3`: it could not be scaled" in text
    assert (folder / "scene.png").is_file()


def test_any_number_and_order_of_shards_gives_the_same_scenes(dataset, whole, tmp_path):
    again = made(dataset, tmp_path, order=(2, 0, 1))
    columns = ["scene", "kind", "split", "grasps", "positive"]
    pd.testing.assert_frame_equal(again.index[columns], whole.index[columns])
    for number in range(len(whole)):
        first, second = whole.scene(number), again.scene(number)
        pd.testing.assert_frame_equal(first.grasps, second.grasps)
        for one, other in zip(first.views, second.views, strict=True):
            np.testing.assert_array_equal(one.depth, other.depth)
    cards = [(folder / "card.md").read_bytes() for folder in (tmp_path, dataset / "scenes")]
    assert cards[0] == cards[1]


def test_without_ancestors_and_evaluation_set(dataset, tmp_path):
    found = made(
        dataset, tmp_path, changes={"scenes": 3, "grasps": 1}, held_out=False, ancestry=False
    )
    assert "By object, each of 8 in one split" in (tmp_path / "card.md").read_text()
    assert found.index["grasps"].max() == 1


def test_mistakes_are_told(dataset, tmp_path):
    files = files_of(dataset) | {"convex_parts": tmp_path / "none.parquet"}
    parquet.write(parquet.empty(CONVEX_PARTS), CONVEX_PARTS, tmp_path / "none.parquet")
    paths = {"out": tmp_path / "scenes-0.parquet", "grasps": tmp_path / "grasps-0.parquet"}
    with pytest.raises(UserError, match="no object of the dataset can be simulated"):
        scenes.run(
            settings_of(),
            "panda",
            meshes=dataset / "rescaled/panda",
            shard=(0, 1),
            **files,
            **paths,
        )
    rows = [dict.fromkeys(EVAL49.names, 0) | {"label": name, "id": f"id-{name}"} for name in NAMES]
    table = pd.DataFrame(rows).assign(object_label="")
    parquet.write(table, EVAL49, tmp_path / "eval49.parquet")
    files = files_of(dataset) | {"evaluation": tmp_path / "eval49.parquet"}
    with pytest.raises(UserError, match=r"all 8 objects are in the evaluation set.*hold_out: fal"):
        scenes.run(
            settings_of(),
            "panda",
            meshes=dataset / "rescaled/panda",
            shard=(0, 1),
            **files,
            **paths,
        )
    folder = dataset / "scenes"
    with pytest.raises(UserError, match="expected scenes in 2 shards"):
        scene_card.run(
            settings_of(SceneParameters), "mine", "panda", folder, 2, **files_of(dataset)
        )
