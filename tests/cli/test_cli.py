import os
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import trimesh
from commands import egad
from described_hands import box_urdf
from forks import Forked
from typer.main import get_command

from egad import __version__
from egad.cli.commands import app
from egad.tables import parquet
from egad.tables.grasping import SCALES, SIZE_EFFECT
from egad.tables.objects import MEASURED, OBJECTS, REJECTED

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "workflow/scripts"


def test_the_version_is_printed():
    assert egad("--version").stdout.strip() == f"egad {__version__}"


def test_help_imports_no_library_that_is_slow_and_little_of_the_workflow():
    code = (
        "import sys, egad.cli.commands\n"
        "slow = {'numba', 'trimesh', 'pybullet', 'mujoco', 'scipy', 'snakemake', 'torch'}\n"
        "slow |= {'numpy', 'pandas', 'pyarrow', 'matplotlib', 'skimage'}\n"
        "slow |= {n for n in sys.modules if n.startswith('egad_workflow.')}\n"
        "usual = {f'egad_workflow.{name}' for name in ('settings', 'datasets', 'program')}\n"
        "print(slow & set(sys.modules) - usual)"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert loaded.stdout.strip() == "set()"


def test_help_lists_what_people_call_and_no_stage_of_the_workflow():
    names = set(get_command(app).commands)
    shown = egad("--help").stdout
    assert all(f" {name} " in shown for name in names)
    stages = {path.stem.replace("_", "-") for path in SCRIPTS.glob("*.py")}
    assert {"evolve", "postprocess", "grasp-label", "select-eval", "simulate"} <= stages - names
    # what people do with meshes, images and hands of their own, too
    assert names & stages == {"bundle", "export", "hands", "rescale", "size-effect"}


def test_a_damaged_table_is_one_sentence_without_a_traceback(tmp_path):
    broken = tmp_path / "archive.parquet"
    broken.write_bytes(b"PAR1 and then nothing")
    result = egad("export-meshes", broken, "--out", tmp_path / "meshes")
    assert result.returncode == 1
    assert "archive.parquet: not a readable Parquet file" in result.stderr
    assert "delete it and run again" in result.stderr
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "meshes").exists()


def unboxed(said):
    """What a box on the terminal says, on one line."""
    return " ".join(said.replace("│", " ").split())


THERE = ["there.obj", "--units", "m"]
RESCALE = ["rescale", "there.obj", "--out", "out"]
CUBE = "\n".join(
    [
        *(f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)),
        *("f 1 2 4", "f 1 4 3", "f 5 7 8", "f 5 8 6", "f 1 5 6", "f 1 6 2"),
        *("f 3 4 8", "f 3 8 7", "f 1 3 7", "f 1 7 5", "f 2 6 8", "f 2 8 4"),
    ]
)


def test_rescale_keeps_files_that_it_did_not_write(tmp_path):
    source, kept = tmp_path / "source", tmp_path / "kept"
    for folder in (source, kept):
        folder.mkdir()
    (source / "cube.obj").write_text(CUBE)
    (kept / "thesis.txt").write_text("years of work")
    for out in (source, kept):
        result = egad("rescale", source, "--units", "m", "--gripper", "0.05", "--out", out)
        assert result.returncode == 1
        assert "would be lost" in result.stderr
    assert (source / "cube.obj").read_text() == CUBE
    assert (kept / "thesis.txt").exists()


def test_rescale_scales_the_good_and_names_the_bad(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "cube.obj").write_text(CUBE)
    (tmp_path / "in" / "list.obj").write_text("milk, eggs")
    given = ["--units", "m", "--gripper", "0.05", "--out", tmp_path / "out"]
    for _ in range(2):  # a second time over its own output
        result = egad("rescale", tmp_path / "in", *given)
        assert result.returncode == 0, result.stderr
    scales = parquet.read(tmp_path / "out" / "scales.parquet", SCALES)
    assert scales["factor"].tolist() == pytest.approx([0.04])
    assert scales[["graspable_fraction_before", "graspable_fraction_after"]].values.tolist() == [
        [0, 1]
    ]
    assert scales["file"].tolist() == ["cube_paper_50mm.obj"]
    assert (tmp_path / "out" / "cube_paper_50mm.obj").exists()
    rejected = parquet.read(tmp_path / "out" / "rejected.parquet", REJECTED)
    assert rejected["id"].tolist() == ["list"]


@pytest.mark.parametrize("content", ["a: [1", "\x80\x81", "seed: -1\nshard: 3"])
def test_check_config_says_what_is_wrong(tmp_path, content):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content.encode("latin-1"))
    result = egad("check-config", path)
    assert result.returncode == 1
    assert "Traceback" not in result.stderr
    if "shard" in content:
        assert "seed" in result.stderr
        assert "shards" in result.stderr


def test_check_config_names_missing_files(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        "detectors: {mine: {detector: grasps:no/a.h5}}\ntargets: {detectors: [mine]}\n"
        "datasets: {parts: {source: meshes, folder: no/parts, units: m}}\n"
    )
    result = egad("check-config", path)
    assert result.returncode == 1
    assert "detectors.mine: no/a.h5 is neither a file of grasps nor a folder" in result.stderr
    assert "datasets.parts: no/parts" in result.stderr


@pytest.fixture
def folder(tmp_path):
    """A cube, and a file that is no mesh."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "cube.obj").write_text(CUBE)
    (tmp_path / "meshes" / "broken.stl").write_text("solid")
    return tmp_path / "meshes"


def test_measure_prints_a_table_and_writes_it_as_csv_and_parquet(folder, tmp_path):
    given = ["measure", folder, "--units", "cm", "--jobs", 1]
    result = egad(*given, "--out", tmp_path / "table.csv")
    assert result.returncode == 0
    assert "cube" in result.stdout
    assert "broken: no faces" in result.stderr
    assert "1 of 2 meshes could not be used" in result.stderr
    assert " ± " in result.stdout
    table = pd.read_csv(tmp_path / "table.csv").set_index("name")
    assert table.columns.tolist() == MEASURED.names[1:]
    assert table.loc["cube", "raw_complexity"] == 0
    assert table.loc["cube", "complexity"] == pytest.approx(1.23, abs=0.05)
    assert table.loc["cube", "graspability"] == pytest.approx(0.0025, abs=0.0003)
    assert table.loc["cube", "cell_confidence"] >= 0.99
    assert 0 < table.loc["cube", "graspability_std"] < 0.0001
    assert table.loc["broken", "reason"] == "no faces"
    egad(*given, "--out", tmp_path / "table.parquet", "--max-candidates", 200)
    assert parquet.read(tmp_path / "table.parquet", MEASURED)["name"].tolist() == ["broken", "cube"]


def test_measure_says_at_which_size_and_what_cannot_be_compared(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    out = tmp_path / "sizes.csv"
    given = ["measure", tmp_path / "cube.obj", "--units", "cm", "--jobs", 1, "--out", out]
    given += ["--max-candidates", 200]
    result = egad(*given)
    titles = ["name", "complexity, bit", "graspability, 1e-3", "cell"]
    assert re.split("  +", result.stdout.splitlines()[0].strip()) == titles
    assert pd.read_csv(out)["grasped_1"].tolist() == [pytest.approx(0.04)]
    assert "cannot be compared" not in result.stdout
    result = egad(*given, "--rule", "none")
    assert pd.read_csv(out)["grasped_3"].tolist() == [pytest.approx(0.01)]
    assert "they are for the rule none and yumi" in result.stdout
    assert "'papr' is not one of 'paper'" in egad(*given, "--rule", "papr").stderr


def test_a_file_named_twice_is_taken_once(folder):
    files = [folder, folder / "cube.obj"]
    result = egad("measure", *files, "--units", "cm", "--jobs", 1, "--max-candidates", 200)
    assert result.stdout.count("cube") == 1
    assert "cube.obj is given twice" in result.stderr


def test_the_table_is_written_even_if_nobody_reads_the_terminal(folder, tmp_path):
    out = tmp_path / "table.csv"
    code = "from egad.cli import main; main()"
    given = ["measure", folder, "--units", "m", "--jobs", "1", "--out", out]
    given += ["--max-candidates", "200"]
    reading, writing = os.pipe()
    os.close(reading)
    Forked(["-c", code, *given], files={1: writing}).wait()
    os.close(writing)
    assert len(pd.read_csv(out)) == 2


def test_locate_writes_a_page_and_a_table(folder, tmp_path):
    """Among two objects, of which one is the mesh itself."""
    dataset = tmp_path / "dataset"
    (dataset / "meshes").mkdir(parents=True)
    names = OBJECTS.names
    objects = pd.DataFrame(0, index=range(2), columns=names).assign(
        id=["1", "2"], label=["A00_0", "B01_0"], complexity=[0.0, 2.0], graspability=[0.003, 0.001]
    )
    parquet.write(objects, OBJECTS, dataset / "objects.parquet")
    (dataset / "meshes" / "A00_0.obj").write_text(CUBE)
    trimesh.creation.torus(0.04, 0.01).export(dataset / "meshes" / "B01_0.obj")
    page, table = tmp_path / "page.html", tmp_path / "table.csv"
    given = ["--units", "cm", "--in", dataset, "--jobs", 1, "--out", page, "--out", table]
    result = egad("locate", folder, *given)
    assert result.returncode == 0, result.stderr
    assert "A00_0" in result.stdout
    row = pd.read_csv(table).set_index("name").loc["cube"]
    assert row["nearest"] == "A00_0 B01_0"
    assert row["distances"].startswith("0.0 0.")
    assert row["difficulty_percentile"] == 50
    text = page.read_text()
    assert "cube" in text
    assert "broken" in text


def test_export_says_what_is_allowed(tmp_path):
    (tmp_path / "grasps").mkdir()
    given = ["export", tmp_path, "--out", tmp_path / "out", "--gripper", "hand", "--format"]
    assert "neither a table of grasps nor a dataset" in egad(*given, "dexnet").stderr
    (tmp_path / "grasps" / "yumi.parquet").touch()
    assert "no grasps for gripper 'hand'; available: yumi" in egad(*given, "acronym").stderr
    (tmp_path / "grasps" / "hand.parquet").touch()
    unknown = egad(*given, "dexnet")
    assert "--gripper 'hand' is not known in the configuration (--config)" in unknown.stderr
    refused = egad(*given, "step")
    assert refused.returncode != 0
    assert "dexnet" in refused.stderr
    assert "Traceback" not in unknown.stderr + refused.stderr


def test_size_effect_rates_the_good_and_names_the_bad(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    (tmp_path / "list.obj").write_text("milk, eggs")
    config = tmp_path / "quick.yaml"
    config.write_text("size_effect: {fractions: [0.5, 1.2], repeats: 2}")
    out = [tmp_path / name for name in ("curve.svg", "curve.csv", "curve.parquet")]
    files = [word for path in out for word in ("--out", path)]
    options = ["--units", "mm", "--gripper", "yumi", "--config", config, "--grasps", 10]
    result = egad("size-effect", tmp_path / "cube.obj", tmp_path / "list.obj", *options, *files)
    assert result.returncode == 0, result.stderr
    assert "list: no faces" in result.stderr
    table = parquet.read(out[2], SIZE_EFFECT)
    assert pd.read_csv(out[1])["quality"].notna().tolist() == [True] * 6 + [False] * 6
    assert set(table["name"]) == {"cube"}
    assert "</svg>" in out[0].read_text()
    assert "cube" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([*RESCALE, "--gripper", "-1"], "--gripper -1: opening is -1.0; allowed: a number, above"),
        ([*RESCALE, "--gripper", "80mm"], "'80mm' is not known, nor is it an opening in metres"),
        ([*RESCALE, "--gripper", "0.05", "--rule", "papr"], "'egad-script'"),
        (["measure", "there.obj"], "--units"),
        (["measure", *THERE, "--out", "table.xlsx"], "must end in .parquet or .csv"),
        (["measure", *THERE, "--out", "no/such/table.csv"], "there is no folder no/such"),
        (["measure", *THERE, "--max-candidates", "-3"], "--max-candidates"),
        (["locate", *THERE, "--in", "nothing.parquet"], "nothing.parquet is neither"),
        (["size-effect", "a.obj", "--units", "mm"], "none of the 1 meshes could be used"),
        (["view", "A0", "--in", "nowhere"], "no dataset here"),
        (["view", "there.obj"], "there.obj does not state its unit; give `units`"),
        (["view", "A0", "--rule", "exact"], "--rule is for mesh files"),
        (["view", "A0", "--gripper", 0.05], "--gripper '0.05' is not known in the configuration"),
    ],
)
def test_commands_say_what_is_allowed(tmp_path, monkeypatch, arguments, sentence):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.obj").write_text(CUBE)
    result = egad(*arguments)
    assert result.returncode in (1, 2)
    assert sentence in unboxed(result.stderr)
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    "command",
    [
        ["rescale", "cube.obj", "--gripper", 0.08, "--jobs", 1, "--out"],
        ["view", "cube.obj", "--grasps", 3, "--out"],
    ],
)
def test_commands_doubt_a_unit_that_makes_a_mesh_too_large(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((60, 60, 60)).export(tmp_path / "cube.obj")
    doubt = "larger than 1 m, for example cube"
    assert doubt in egad(*command, "large.html", "--units", "m").stderr
    assert doubt not in egad(*command, "small.html", "--units", "mm").stderr


def test_the_file_of_a_hand_is_inspected(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    box_urdf(tmp_path / "My Hand.urdf")
    found = egad("gripper", "inspect", "My Hand.urdf")
    assert found.returncode == 0
    assert "0.2 to 80.2 mm" in found.stdout
    entry = "grippers:" + found.stdout.split("grippers:")[1].split("\nsee ")[0]
    (tmp_path / "hand.yaml").write_text(entry)
    page = (tmp_path / "my_hand.html").read_bytes()
    named = egad("gripper", "inspect", "my_hand", "--config", "hand.yaml", "--out", "again.html")
    assert named.returncode == 0
    assert (tmp_path / "again.html").read_bytes() == page
    box_urdf(tmp_path / "panda.urdf")  # as a gripper that is shipped
    assert "\n  my_panda:\n" in egad("gripper", "inspect", "panda.urdf").stdout
    assert "no `file`" in egad("gripper", "inspect", "panda").stderr
    assert "gripper or file 'nothing'" in egad("gripper", "inspect", "nothing").stderr
