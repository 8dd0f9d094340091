"""Datasets of objects: the released one, and broken requests."""

import numpy as np
import pandas as pd
import pytest

import egad
from egad.cppn.parameters import Shape
from egad.cppn.query import query
from egad.cppn.voxels import identity, solid
from egad.data import released
from egad.errors import TableError, UserError


@pytest.fixture(scope="module")
def objects():
    return egad.load("released")


def test_the_released_dataset_has_a_row_and_a_label_for_each_object(objects):
    assert len(objects) == len(objects.table) == objects.table["label"].nunique() == 2305
    assert [each.label for each in objects][:3] == objects.table["label"].tolist()[:3]
    row = objects.table.iloc[7]
    assert objects[row["id"]].label == row["label"] in objects


def test_an_object_has_voxels_that_its_id_is_the_hash_of(objects):
    each = objects["M14_3"]
    assert each.voxels.shape == (Shape().resolution,) * 3
    assert identity(each.voxels) == each.id
    assert each.mesh.is_watertight
    assert each.mesh.body_count == 1


def test_the_genome_describes_the_voxels(objects):
    each, shape = objects["M14_3"], Shape()
    output = query(each.genome, shape.resolution)
    assert np.array_equal(solid(output, shape.threshold), each.voxels)


def test_the_mesh_has_the_volume_of_the_voxels(objects):
    each = objects["M14_3"]
    low, high = each.mesh.bounds
    filled = np.argwhere(each.voxels)
    step = (high - low) / (filled.max(axis=0) + 1 - filled.min(axis=0))
    assert each.mesh.volume == pytest.approx(each.voxels.sum() * step.prod(), rel=0.05)


def test_a_selection_has_the_order_of_its_names(objects):
    chosen = objects.select(["M14_3", objects["E08_0"].id, "M14_3"])
    assert [each.label for each in chosen] == ["M14_3", "E08_0"]
    assert chosen.table["label"].tolist() == ["M14_3", "E08_0"]
    assert chosen["E08_0"].id == objects["E08_0"].id
    with pytest.raises(UserError, match="did you mean"):
        objects.select(["M14_33"])


def test_a_single_name_selects_one_object(objects):
    assert [each.label for each in objects.select("M14_3")] == ["M14_3"]


@pytest.mark.parametrize("name", [0, -1, slice(3), ["M14_3"], None])
def test_only_names_are_names(objects, name):
    with pytest.raises(UserError, match="by its label or id, got"):
        objects[name]
    with pytest.raises(UserError, match="by its label or id, got"):
        objects.select([name])


def test_a_position_selects_nothing(objects):
    with pytest.raises(UserError, match="by its label or id, got 3"):
        objects.select(3)


def test_an_archive_loads_from_its_file(objects, tmp_path):
    path = tmp_path / "archive.parquet"
    path.write_bytes(released().read_bytes())
    pd.testing.assert_frame_equal(egad.load(path).table, objects.table)


def test_what_is_no_dataset_is_a_sentence(tmp_path):
    with pytest.raises(UserError, match="neither 'released', nor a folder"):
        egad.load(tmp_path)
    with pytest.raises(UserError, match="neither 'released', nor a folder"):
        egad.load("relaesed")
    (tmp_path / "archive.parquet").write_bytes(b"PAR1 but no more")
    with pytest.raises(TableError, match="not a readable Parquet file"):
        egad.load(tmp_path / "archive.parquet")
    frame = pd.DataFrame({"id": ["a"]})
    frame.to_parquet(tmp_path / "other.parquet")
    with pytest.raises(TableError):
        egad.load(tmp_path / "other.parquet")
