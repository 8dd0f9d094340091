"""The datasheet: what it says of a small set, and that its table of trials can be read again."""

import datasheet
import numpy as np
import pandas as pd
import pytest
import trimesh
from partial_tables import fill_columns, write_rows

from egad.bench.stats import read
from egad.errors import UserError
from egad.evalset import DataSheets, ForGripper, PrintExport
from egad.evalset.datasheet import page
from egad.io import write_stl_mm
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST
from egad.tables.grasping import GRASPS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(select_eval={"rows": 2, "columns": 2}), DataSheets)
LABELS = ["A0", "A1", "B0"]  # B1 is empty
NO_MESH = "no mesh egad-1.obj: no such file"


@pytest.fixture
def sheet(tmp_path):
    """Makes the datasheet of three objects, of which the second has no mesh."""

    def make(out="eval49"):
        prints = tmp_path / "print"
        prints.mkdir(exist_ok=True)
        chosen = [
            {
                "label": label,
                "object_label": f"egad-{n}",
                "row": n // 2,
                "column": n % 2,
                "borrowed": label == "A1",
            }
            for n, label in enumerate(LABELS)
        ]
        manifest = [
            {"label": "A0", "file": "A0.stl", "plate": 1, "extents_x": 40, "filament": 7.4},
            {"label": "A1", "plate": None, "note": NO_MESH},
            {"label": "B0", "file": "B0.stl", "plate": 2, "extents_x": 30, "filament": np.nan},
        ]
        grasps = [
            {"label": "egad-0", "collision_free": True, "quality": 0.00123},
            {"label": "egad-0", "collision_free": False, "quality": 0.009},
            {"label": "egad-2", "collision_free": False, "quality": 0.008},
        ]
        for label in ("A0", "B0"):
            write_stl_mm(trimesh.creation.box((0.04, 0.02, 0.01)), prints / f"{label}.stl")
        write_rows(EVAL49, chosen, tmp_path / "eval49.parquet")
        write_rows(MANIFEST, manifest, prints / "manifest.parquet")
        write_rows(GRASPS, grasps, tmp_path / "grasps.parquet")
        datasheet.run(
            SETTINGS,
            "egad",
            tmp_path / "eval49.parquet",
            ["yumi"],
            [prints / "manifest.parquet"],
            [tmp_path / "grasps.parquet"],
            tmp_path / out,
        )
        return tmp_path / out

    return make


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_every_object_is_in_both_tables_and_what_is_missing_is_named(sheet):
    text = (sheet() / "README.md").read_text()
    assert "3 of 4 cells of the grid are filled" in text
    assert "No printable object lies in B1." in text
    assert "A1: no printable object lies in the cell itself" in text
    rows = [cells(line) for line in text.splitlines() if line.startswith("| ")]
    assert [row[0] for row in rows if row[0] in LABELS] == LABELS * 2
    printed = {row[0]: row for row in rows[-3:]}
    assert printed["A0"][3] == "7"
    assert printed["A1"][5:] == ["", NO_MESH]
    assert printed["B0"][3] == ""


@pytest.mark.parametrize(
    ("engraved", "expected"),
    [
        ([False, False], "The prints do not carry their labels."),
        ([True, False], "Each print carries its label, except B0."),
        ([True, True], "Each print carries its label.\n"),
    ],
)
def test_it_says_which_prints_can_be_told_apart(engraved, expected):
    rows = [
        {"label": label, "engraved": marked, "plate": 1}
        for label, marked in zip(["A0", "B0"], engraved, strict=True)
    ]
    rows.append({"label": "A1", "engraved": False, "plate": None})  # not printed
    manifest = fill_columns(MANIFEST, pd.DataFrame(rows))
    chosen = parquet.empty(EVAL49)
    grippers = {"yumi": ForGripper(manifest, {})}
    text = page("egad", chosen, ["A0"], grippers, PrintExport())
    assert expected in text


def test_the_best_quality_is_that_of_a_grasp_that_the_hand_reaches(sheet):
    lines = (sheet() / "README.md").read_text().splitlines()
    best = {cells(line)[0]: cells(line)[4] for line in lines if line.startswith("| ")}
    assert (best["A0"], best["B0"]) == ("1.23", "")


def test_the_table_of_trials_is_read_once_it_is_filled_in(sheet):
    path = sheet() / "trials.csv"
    frame = pd.read_csv(path, dtype=str, keep_default_na=False)
    assert frame.groupby("label").size().to_dict() == dict.fromkeys(LABELS, 20)
    with pytest.raises(UserError, match="no row says whether the attempt was a success"):
        read(path)
    frame.loc[:1, "success"] = ["1", "0"]
    frame.to_csv(path, index=False)
    (found,) = read(path).values()
    assert found["outcome"].tolist() == ["success", "other"]


def test_the_contact_sheet_is_one_page_and_the_same_every_time(sheet):
    first, again = (sheet(name) / "contact-sheet.pdf" for name in ("one", "two"))
    content = first.read_bytes()
    assert content.startswith(b"%PDF")
    assert content.count(b"/Type /Page\n") + content.count(b"/Type /Page ") == 1
    assert content == again.read_bytes()
