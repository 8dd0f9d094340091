"""The folder of a matched set: what is in it, and that the other commands read it."""

import re
from contextlib import nullcontext

import bars
import pandas as pd
import pytest
from commands import egad as run

import egad
from egad.bench.failures import MatchedSet
from egad.cli.matched_folder import write_matched_set
from egad.io import read_mesh
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST
from egad.tables.failures import MATCHED
from egad.tables.grasping import GRASPS, SCALES
from egad_workflow.settings import Settings

LABELS = ["A0", "A1", "B0", "B1"]


@pytest.fixture(scope="module")
def folder(matched, tmp_path_factory):
    out = tmp_path_factory.mktemp("matched") / "bars"
    write_matched_set(Settings(), "panda", matched, "bars", out)
    return out


def test_the_set_is_read_as_a_dataset(folder, matched):
    objects = egad.load(folder)
    assert set(objects.table["id"]) == set(matched.table["id"])
    assert all(each.mesh.is_watertight and each.voxels.any() and each.genome for each in objects)
    assert MatchedSet.load(folder).table["label"].tolist() == LABELS


def test_failures_are_row_a_and_their_partners_row_b(folder):
    chosen = parquet.read(folder / "eval49.parquet", EVAL49).set_index("label")
    pairs = parquet.read(folder / "pairs.parquet", MATCHED).set_index("label")
    assert chosen.index.tolist() == LABELS
    assert chosen["id"].tolist() == pairs["id"].tolist()
    assert chosen["row"].tolist() == [0, 0, 1, 1]
    assert chosen["column"].tolist() == pairs["pair"].tolist()
    assert pairs["is_failure"].tolist() == [True, True, False, False]


def test_prints_are_scaled_and_carry_their_labels(folder):
    manifest = parquet.read(folder / "print/panda/manifest.parquet", MANIFEST)
    assert manifest["label"].tolist() == LABELS
    assert manifest["engraved"].all()
    assert (folder / "print/panda/plate-1.3mf").is_file()
    scales = parquet.read(folder / "rescaled/panda/scales.parquet", SCALES).set_index("label")
    names = parquet.read(folder / "eval49.parquet", EVAL49).set_index("label")["object_label"]
    for row in parquet.records(manifest):
        assert row["factor"] == scales.loc[names[row["label"]], "factor"]
        assert read_mesh(folder / "print/panda" / row["file"], "mm").is_watertight
    grasps = parquet.read(folder / "grasps/panda.parquet", GRASPS)
    assert set(grasps["label"]) == set(names)


def test_the_datasheet_says_how_often_each_was_held(folder):
    text = (folder / "eval49/README.md").read_text()
    assert "Failures of the detector bars" in text
    lines = [line for line in text.splitlines() if re.match(r"\| [AB]\d \| [AB]\d ", line)]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert [row[:2] for row in cells] == [["A0", "B0"], ["A1", "B1"], ["B0", "A0"], ["B1", "A1"]]
    assert [row[3:] for row in cells[:2]] == [["0 of 5", "5 of 5"]] * 2
    assert [row[3:] for row in cells[2:]] == [["5 of 5", "5 of 5"]] * 2
    assert "partners: detector 100 %, reference 100 % of 10" in text
    assert "succeeds in less than 80 %: 1" in text
    assert "without a partner, left out: 0" in text
    assert (folder / "eval49/contact-sheet.pdf").read_bytes().startswith(b"%PDF")


def test_a_log_sheet_of_it_is_read_by_the_report(folder, tmp_path):
    order = tmp_path / "order.csv"
    done = run("log-sheet", folder, "--detectors", "mine", "--attempts", 2, "--out", order)
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(order, dtype=str, keep_default_na=False)
    assert table.groupby("label").size().to_dict() == dict.fromkeys(LABELS, 2)
    table["success"] = table["label"].str.startswith("B").astype(int)
    table.to_csv(tmp_path / "filled.csv", index=False)
    done = run("trials", "report", tmp_path / "filled.csv", "--out", tmp_path / "report.html")
    assert done.returncode == 0, done.stderr
    assert "50.0" in done.stdout


def test_a_command_makes_it_of_an_atlas_with_several_processes_to_the_last_byte(
    failing, folder, tmp_path, monkeypatch
):
    monkeypatch.setattr("egad.bench.failures.matched.load", lambda: bars.NONE)
    monkeypatch.setattr("egad_workflow.provenance.recorded", lambda *_, **__: nullcontext())
    monkeypatch.setenv("EGAD_CACHE_DIR", "off")  # convex parts are made again, too
    failing.save(tmp_path / "atlas")
    out = tmp_path / "bars"

    def command(*more):
        given = ("--detector", f"{bars.__file__}:thick_only", "--out", out, "--jobs", 2)
        return run("matched-set", tmp_path / "atlas", *given, *more)

    done = command("--pairs", 2, "--attempts", 5)
    assert done.returncode == 0, done.stderr
    assert "MatchedSet(2 pairs; mujoco: detector 0 % at failures and 100 % at" in done.stdout
    assert "fewer pairs" not in done.stdout
    assert (out / "log.html").read_text().count("<figure>") == 4
    manifest = parquet.read(out / "print/panda/manifest.parquet", MANIFEST)
    assert manifest["file"].tolist() == [f"{label}_paper_80mm.stl" for label in LABELS]
    (out / "log.html").unlink()  # written besides the set
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(out) for path in out.rglob("*") if path.is_file())
    assert [
        name for name in files if (folder / name).read_bytes() != (out / name).read_bytes()
    ] == []
    other = command("--gripper", "yumi")
    assert "found with another gripper" in other.stderr
    (out / "pairs.parquet").unlink()
    assert "has other files, which would be lost" in command().stderr
