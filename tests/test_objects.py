"""Datasets of objects: the released one, and broken requests."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from partial_tables import write_rows

import egad
from egad.data import released
from egad.errors import RejectedError, TableError, UserError
from egad.evolution import UNBOUND, Shape
from egad.evolution.constraints import solid
from egad.evolution.query import query
from egad.evolution.voxels import identity
from egad.objects import named_meshes, scaled_solid
from egad.tables.objects import OBJECTS


@pytest.fixture(scope="module")
def objects():
    return egad.load("released")


def test_the_released_dataset_has_a_row_and_a_label_for_each_object(objects):
    assert len(objects) == len(objects.table) == objects.table["label"].nunique() == 2198
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
    assert np.array_equal(solid(output, shape.threshold, UNBOUND), each.voxels)


def test_a_selection_has_the_order_of_its_names(objects):
    chosen = objects.select(["M14_3", objects["E08_0"].id, "M14_3"])
    assert [each.label for each in chosen] == ["M14_3", "E08_0"]
    assert chosen.table["label"].tolist() == ["M14_3", "E08_0"]
    assert chosen["E08_0"].id == objects["E08_0"].id
    with pytest.raises(UserError, match="did you mean"):
        objects.select(["M14_33"])


NO_NAMES = [0, 3, -1, slice(3), True, np.True_, None]
NO_NAMES += [[0], np.array([0, 1]), [["M14_3"]], ["M14_3", None], [b"M14_3"]]


@pytest.mark.parametrize("given", NO_NAMES)
def test_only_names_are_names(objects, given):
    for choose in (objects.__getitem__, objects.select):
        with pytest.raises(UserError, match="by its label or id, got"):
            choose(given)


def test_several_names_give_the_dataset_that_select_gives(objects):
    names = ["M14_3", objects["E08_0"].id, "M14_3"]
    expected = objects.select(names).table
    for given in (names, tuple(names), np.array(names), pd.Series(names), pd.Index(names)):
        assert isinstance(objects[given], egad.Dataset)
        pd.testing.assert_frame_equal(objects[given].table, expected)
    assert len(objects[[]]) == 0
    with pytest.raises(UserError, match="did you mean"):
        objects[["M14_33"]]


def test_booleans_give_the_dataset_of_those_objects(objects):
    column = objects.table["complexity"] > 3
    expected = objects.table[column].reset_index(drop=True)
    assert 0 < len(expected) < len(objects)
    for mask in (column, column.to_numpy(), column.tolist(), column.astype("boolean")):
        found = objects[mask]
        pd.testing.assert_frame_equal(found.table, expected)
    assert found["M14_3"].id == objects["M14_3"].id
    again = found[found.table["label"] == "M14_3"]
    assert [each.label for each in again] == ["M14_3"]
    assert len(objects[column & ~column]) == 0
    assert len(objects[column | ~column]) == len(objects)


def test_booleans_of_objects_with_the_same_mesh_choose_by_row(tmp_path):
    rows = [{"id": "same", "label": label} for label in ("A00_0", "A00_1")]
    write_rows(OBJECTS, rows, tmp_path / "objects.parquet")
    assert egad.load(tmp_path)[[True, False]].table["label"].tolist() == ["A00_0"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda mask: mask[:3], r"got 3 booleans for 2198 objects"),
        (lambda mask: mask.to_numpy()[None], "by its label or id, got array"),
        (lambda mask: mask.astype("boolean").mask(mask), "some are missing"),
        (lambda mask: [None, *mask.tolist()[1:]], "some are missing"),
        (lambda mask: mask.set_axis(mask.index + 1), "rows of another table"),
        (lambda mask: mask.set_axis(mask.index // 2), "rows of another table"),
    ],
)
def test_booleans_that_are_not_one_for_each_object_are_told(objects, change, message):
    with pytest.raises(UserError, match=message):
        objects[change(objects.table["complexity"] > 3)]


def test_an_archive_loads_from_its_file(objects, tmp_path):
    path = tmp_path / "archive.parquet"
    path.write_bytes(released().read_bytes())
    found = egad.load(path).table
    pd.testing.assert_frame_equal(found, objects.table[found.columns])


def test_what_is_no_dataset_is_a_sentence(tmp_path):
    for source in (tmp_path, "relaesed"):
        with pytest.raises(UserError, match="neither 'released'"):
            egad.load(source)
    (tmp_path / "archive.parquet").write_bytes(b"PAR1 but no more")
    with pytest.raises(TableError, match="not a readable Parquet file"):
        egad.load(tmp_path / "archive.parquet")
    frame = pd.DataFrame({"id": ["a"]})
    frame.to_parquet(tmp_path / "other.parquet")
    with pytest.raises(TableError):
        egad.load(tmp_path / "other.parquet")
    for source in (None, 3):
        with pytest.raises(UserError, match=f"source is {source}; allowed: a path"):
            egad.load(source)


@pytest.mark.parametrize("content", [None, "milk, eggs"])
def test_a_mesh_file_that_a_dataset_lacks_is_named(tmp_path, content):
    """An error of the dataset: no failure of the detector, nothing that an export leaves out."""
    write_rows(OBJECTS, [{"id": "d", "label": "D03_0"}], tmp_path / "objects.parquet")
    if content:
        (tmp_path / "meshes").mkdir()
        (tmp_path / "meshes/D03_0.obj").write_text(content)
    dataset = egad.load(tmp_path)
    for use in (
        lambda: dataset["D03_0"].mesh,
        lambda: egad.run_trials("random", dataset, "panda", attempts=1),
        lambda: egad.export(dataset, "obj", "panda", tmp_path / "out"),
    ):
        with pytest.raises(UserError, match=r"meshes/D03_0\.obj: no"):
            use()


BOX = trimesh.creation.box((0.1, 0.2, 0.3))
SIDE = 0.8 * 0.08  # of the opening of the panda gripper


@pytest.mark.parametrize("given", [[BOX], BOX, None, "released", {1: BOX}, {"a": BOX, None: BOX}])
def test_objects_are_a_dataset_or_meshes_by_name(objects, given, tmp_path):
    for wrong in (given, objects["M14_3"]):
        with pytest.raises(UserError, match=r"objects must be a dataset, .* of meshes by name"):
            egad.run_trials("random", wrong, "panda")
        with pytest.raises(UserError, match=r"objects must be a dataset, .* of meshes by name"):
            egad.export(wrong, "obj", "panda", tmp_path / "out")


@pytest.mark.parametrize(("rule", "side"), [("paper", SIDE), ("none", 0.1)])
@pytest.mark.parametrize("turned", [False, True])
def test_a_solid_is_wound_outwards_and_scaled(rule, side, turned):
    box = BOX.copy()
    if turned:
        box.invert()
    (target,) = named_meshes({"box": box})
    mesh = scaled_solid(target, egad.gripper("panda"), rule)
    assert mesh.volume == pytest.approx(6 * side**3)
    assert box.volume == pytest.approx(-0.006 if turned else 0.006)


def test_a_surface_that_bounds_no_solid_is_rejected():
    sheet = trimesh.Trimesh(BOX.vertices, BOX.faces[2:], process=False)
    (target,) = named_meshes({"sheet": sheet})
    with pytest.raises(RejectedError, match="open or inconsistently wound surface"):
        scaled_solid(target, egad.gripper("panda"), "paper")


def test_the_evaluation_set_is_of_released_objects_under_its_own_labels():
    chosen, whole = egad.load("evaluation-set"), egad.load("released")
    letters, digits = zip(*(each.label for each in chosen), strict=True)
    assert len(chosen) == 49
    assert sorted(set(letters)) == list("ABCDEFG")
    assert sorted(set(digits)) == list("0123456")
    assert all(each.id in whole for each in chosen)
    hard = whole[chosen["G6"].id]
    assert np.array_equal(chosen["G6"].voxels, hard.voxels)
    # the letters go from easy to hard, the digits from simple to complex
    table = chosen.table.assign(row=letters, column=digits)
    assert table.groupby("row")["graspability"].mean().is_monotonic_decreasing
    assert table.groupby("column")["complexity"].mean().is_monotonic_increasing
