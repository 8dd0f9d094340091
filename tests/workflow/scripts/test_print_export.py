import logging

import pandas as pd
import print_export
import pytest
import trimesh
from partial_tables import write_rows

from egad.evalset import PrintFiles
from egad.io import read_mesh, write_obj
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST
from egad.tables.grasping import GRASPS, SCALES
from egad_workflow.settings import Settings, select


def exported(folder, sides, grasps=None, **changes):
    """The manifest of cubes with these sides, metres; None: the mesh is missing."""
    folder.mkdir()
    for number, side in enumerate(sides):
        if side is not None:
            write_obj(trimesh.creation.box((side,) * 3), folder / f"box{number}.obj")
    labels = [f"A{number}" for number in range(len(sides))]
    chosen = [{"label": each, "id": each, "object_label": f"box{each[1:]}"} for each in labels]
    write_rows(EVAL49, chosen, folder / "eval49.parquet")
    parquet.write(parquet.empty(SCALES), SCALES, folder / "scales.parquet")
    print_export.run(
        select(Settings(print_export={"bed": (0.05, 0.05)} | changes), PrintFiles, "yumi"),
        "yumi",
        folder / "eval49.parquet",
        folder,
        folder / "scales.parquet",
        folder / "print",
        grasps,
    )
    return parquet.read(folder / "print/manifest.parquet", MANIFEST).set_index("label")


def test_what_cannot_be_printed_is_a_row_with_a_note_and_the_rest_is_made(tmp_path):
    rows = exported(tmp_path / "a", [0.02, None, 0.001, 0.06])
    assert rows["note"]["A0"] == ""
    assert rows["note"]["A1"] == "no mesh box1.obj: no such file"
    assert rows["note"]["A2"] == "not printable at this size: walls thinner than 1.2 mm"
    assert rows["note"]["A3"] == "60 x 60 mm plus a gap of 5 mm do not fit the bed of 50 x 50 mm"
    assert rows["plate"].tolist()[0] == 1
    assert rows["plate"][1:].isna().all()
    assert rows["volume"]["A0"] == pytest.approx(8000)
    assert (tmp_path / "a/print/plate-1.3mf").exists()
    assert sorted(path.name for path in (tmp_path / "a/print").glob("*.stl")) == [
        "A0_paper_50mm.stl",
        "A2_paper_50mm.stl",
        "A3_paper_50mm.stl",
    ]


def test_labels_are_cut_into_the_prints_away_from_usable_grasps(tmp_path):
    grasps = pd.DataFrame(0, index=range(2), columns=GRASPS.names)
    grasps["id"], grasps["label"] = "box0", "box0"
    grasps["collision_free"] = [True, False]
    grasps["contact0_z"], grasps["contact1_z"] = [0.01, 0.0], [-0.01, 0.0]
    grasps["contact0_x"], grasps["contact1_x"] = [0.0, 0.01], [0.0, -0.01]
    parquet.write(grasps, GRASPS, tmp_path / "grasps.parquet")
    table = tmp_path / "grasps.parquet"
    rows = exported(tmp_path / "c", [0.02, 0.006], table, engraving=True)
    assert rows["engraved"].tolist() == [True, False]
    assert rows["note"]["A0"] == ""
    assert "no space for its label" in rows["note"]["A1"]
    assert 8000 - rows["volume"]["A0"] == pytest.approx(20, abs=8)
    assert read_mesh(tmp_path / "c/print/A0_paper_50mm.stl", "mm").is_watertight


def test_a_gripper_that_nothing_can_be_printed_for_is_said(tmp_path, caplog):
    with caplog.at_level(logging.WARNING):
        rows = exported(tmp_path / "b", [0.0005, 0.001])
    assert rows["plate"].isna().all()
    assert "No object can be printed for gripper yumi with its opening of 50 mm" in caplog.text
