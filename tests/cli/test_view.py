import numpy as np
import pandas as pd
import pytest
import trimesh
from partial_tables import write_rows

from egad.cli import view
from egad.cli.view import ViewMesh
from egad.errors import UserError
from egad.grasps import GraspLabel
from egad.report.viewer import scenes
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import GRASPS, SCALES
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(grasp_label=GraspLabel(grasps=6)), ViewMesh, "yumi")
OPENING = 0.05


@pytest.fixture
def dataset(tmp_path):
    """Two objects, D03_0 with two grasps and E04_1 without any; the first is A0 of the set."""
    labels = ["D03_0", "E04_1"]
    scaled = tmp_path / "rescaled" / "yumi"
    scaled.mkdir(parents=True)
    (tmp_path / "grasps").mkdir()
    for name in labels:
        trimesh.creation.box([0.03, 0.04, 0.05]).export(scaled / f"{name}.obj")
    names = pd.DataFrame({"id": ["d", "e"], "label": labels})
    qualities = [{"grasp": n, "quality": quality} for n, quality in enumerate((0.001, 0.002))]
    grasps = pd.DataFrame(qualities).assign(id="d", label="D03_0")
    left_out = [{"id": "e", "reason": "no grasp (of 9 candidates)"}]
    chosen = pd.DataFrame({"label": ["A0", "B1"], "object_label": labels})
    write_rows(OBJECTS, names, tmp_path / "objects.parquet")
    write_rows(SCALES, names[["label"]].assign(opening=OPENING), scaled / "scales.parquet")
    write_rows(GRASPS, grasps, tmp_path / "grasps" / "yumi.parquet")
    write_rows(REJECTED, left_out, tmp_path / "grasps" / "yumi.rejected.parquet")
    write_rows(EVAL49, chosen, tmp_path / "eval49.parquet")
    return tmp_path


@pytest.mark.parametrize("name", ["D03_0", "A0"])
def test_an_object_is_found_by_its_label_here_and_in_the_evaluation_set(dataset, name):
    found = view.from_dataset(dataset, "yumi", name, OPENING)
    assert found.name == "D03_0"
    assert found.grasps["quality"].tolist() == [0.001, 0.002]
    assert found.note == ""
    assert found.mesh.extents == pytest.approx([0.03, 0.04, 0.05])


def test_an_object_without_grasps_is_shown_with_the_reason(dataset):
    found = view.from_dataset(dataset, "yumi", "E04_1", OPENING)
    assert len(found.grasps) == 0
    assert found.note == "no grasp (of 9 candidates)"


@pytest.mark.parametrize(
    ("gripper", "name", "sentence"),
    [
        ("yumi", "D03_1", "object 'D03_1' is not known in .*; did you mean D03_0"),
        ("yumi", "zzz", "known: A0, B1, D03_0, E04_1"),
        ("panda", "D03_0", r"panda/scales.parquet is missing; make it with: snakemake .*panda"),
    ],
)
def test_what_is_not_there_is_named_with_what_is(dataset, gripper, name, sentence):
    with pytest.raises(UserError, match=sentence):
        view.from_dataset(dataset, gripper, name, OPENING)


def test_another_opening_than_that_of_the_dataset_is_refused(dataset):
    with pytest.raises(UserError, match=r"'yumi' opens 0\.06 m in the settings, but 0\.05 m in"):
        view.from_dataset(dataset, "yumi", "D03_0", 0.06)


def test_the_evaluation_set_keeps_its_names_and_skips_what_was_not_scaled(dataset):
    evalset = parquet.read(dataset / "eval49.parquet", EVAL49)
    grasps = parquet.read(dataset / "grasps" / "yumi.parquet", GRASPS)
    shown = scenes(dataset, "yumi", evalset, grasps)
    assert [(each.name, each.title, len(each.grasps)) for each in shown] == [
        ("A0", "D03_0", 2),
        ("B1", "E04_1", 0),
    ]
    (dataset / "rescaled" / "yumi" / "E04_1.obj").unlink()
    assert len(scenes(dataset, "yumi", evalset, grasps)) == 1


def test_a_mesh_is_scaled_by_the_rule_and_labelled(tmp_path):
    trimesh.creation.box([400, 500, 600]).export(tmp_path / "crate.stl")
    found = view.from_mesh(tmp_path / "crate.stl", "mm", SETTINGS)
    assert np.sort(found.mesh.extents)[0] == pytest.approx(0.8 * 0.05, rel=1e-3)
    assert found.title == "40 x 50 x 60 mm, 0.1 times its size (rule paper)"
    assert 0 < len(found.grasps) <= 6
    again = view.from_mesh(tmp_path / "crate.stl", "mm", SETTINGS)
    assert again.grasps.equals(found.grasps)


def test_a_file_that_is_no_mesh_or_not_closed_is_named(tmp_path):
    box = trimesh.creation.box([40, 20, 30])
    box.update_faces(box.face_normals[:, 2] < 0.5)
    box.export(tmp_path / "open.ply")
    (tmp_path / "list.obj").write_text("milk, eggs")
    for name, reason in (("open.ply", "open"), ("list.obj", "no"), ("gone.stl", "no such file")):
        with pytest.raises(UserError, match=rf"{name}: .*{reason}"):
            view.from_mesh(tmp_path / name, "mm", SETTINGS)
