import importlib

import h5py
import pytest
import yaml
from commands import egad
from typer.testing import CliRunner

from egad.cli.commands import app
from egad.data import released
from egad.grippers.rescaling import rescale
from egad.io import read_mesh
from egad.objects import load
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad_workflow.settings import Settings

GRIPPER = "yumi"


@pytest.fixture
def export(dataset, tmp_path):
    """Runs `egad export` on the dataset."""

    def run(style, out, folder=dataset, **settings):
        config = tmp_path / "config.yaml"
        config.write_text(
            yaml.safe_dump(
                {
                    "dexnet": {"field_size": 16},
                    "acronym": {"min_robust_success_rate": 0},
                    **settings,
                }
            )
        )
        given = ["--gripper", GRIPPER, "--format", style, "--out", out, "--config", config]
        return egad("export", folder, *given)

    return run


def test_a_database_is_made_of_a_folder(export, tmp_path):
    done = export("dexnet", tmp_path / "new" / "grasps.hdf5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "new" / "grasps.hdf5") as file:
        objects = file["datasets/tiny/objects"]
        assert list(objects) == ["A00_0", "B01_0", "C02_0"]
        assert objects["A00_0/sdf/data"].shape == (16, 16, 16)
    left = {path.name for path in (tmp_path / "new").iterdir()}
    assert left == {"grasps.hdf5", "grasps.hdf5.sha256"}


def test_released_objects_are_exported_without_a_run(tmp_path):
    out = tmp_path / "objects"
    done = egad("export", "released", "--gripper", GRIPPER, "--format", "obj", "--out", out)
    assert done.returncode == 0, done.stderr
    objects = load("evaluation-set")
    assert {path.stem for path in out.iterdir()} == set(objects.table["label"])
    assert len(objects) == 49
    label = objects.table["label"].iloc[0]
    expected, _ = rescale(objects[label].mesh, GRIPPER)
    written = read_mesh(out / f"{label}.obj", "m")
    assert written.volume == pytest.approx(expected.volume, rel=1e-6)


@pytest.fixture
def archive(tmp_path):
    """An archive of two objects."""
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.read(released(), ARCHIVE).head(2), ARCHIVE, path)
    return path


@pytest.mark.parametrize(
    ("source", "options", "expected"),
    [
        ("released", [], "evaluation-set"),
        ("released", ["--objects", "evaluation-set"], "evaluation-set"),
        ("released", ["--objects", "all"], "released"),
        ("evaluation-set", [], "evaluation-set"),
    ],
)
def test_the_chosen_objects_are_given_to_the_export(monkeypatch, source, options, expected):
    asked = []
    module = importlib.import_module("egad.exchange.export")
    monkeypatch.setattr(module, "export", lambda objects, *_: asked.append(objects))
    given = ["export", source, "--gripper", GRIPPER, "--format", "obj", "--out", "x", *options]
    done = CliRunner().invoke(app, given, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert list(asked[0].table["id"]) == list(load(expected).table["id"])


@pytest.mark.parametrize("source", [None, "evaluation-set"])
def test_objects_of_a_run_are_not_chosen_without_one(archive, tmp_path, source):
    out, chosen = tmp_path / "objects", source or archive
    given = ["--gripper", GRIPPER, "--format", "obj", "--out", out, "--objects", "all"]
    refused = egad("export", chosen, *given)
    assert refused.returncode == 1
    assert refused.stderr == f"egad: --objects is only for the folder of a run, not for {chosen}\n"
    assert not out.exists()


def test_what_needs_a_run_says_how_to_make_it(tmp_path):
    out = tmp_path / "out.hdf5"
    for style, file in (("dexnet", "grasps/yumi.parquet"), ("jacquard", "images/yumi/card.md")):
        done = egad("export", "released", "--gripper", GRIPPER, "--format", style, "--out", out)
        assert done.returncode == 1
        assert "snakemake --cores 2 --configfile config/released.yaml -- results" in done.stderr
        assert f"results/egad/{file}" in done.stderr
    assert not out.exists()


def test_acronym_files_take_no_folder_of_others(export, tmp_path):
    out = tmp_path / "files"
    for _ in range(2):  # the second time over its own files
        assert export("acronym", out).returncode == 0
    with h5py.File(out / "A00_0.h5") as file:
        values = file["grasps/qualities/egad"]
        assert (values["success"][()] == values["collision_free"][()]).all()
    for name in ("thesis.txt", "measured.h5", ".notes"):
        (out / name).write_text("years of work")
        refused = export("acronym", out)
        assert refused.returncode == 1
        assert f"{name} is not from an earlier export and would be lost" in refused.stderr
        assert (out / name).exists()
        (out / name).unlink()
    assert "is a file" in export("acronym", out / "A00_0.h5").stderr


def test_a_database_has_a_name_that_dexnet_opens(export, tmp_path):
    refused = export("dexnet", tmp_path / "grasps.h5")
    assert refused.returncode == 1
    assert "must end in .hdf5" in refused.stderr
    assert "is a folder" in export("dexnet", tmp_path).stderr


@pytest.mark.parametrize(("style", "name"), [("dexnet", "out.hdf5"), ("acronym", "out")])
def test_another_gripper_of_that_name_is_refused(export, tmp_path, style, name):
    wider = {"yumi": {**Settings().grippers["yumi"].model_dump(), "opening": 0.06}}
    refused = export(style, tmp_path / name, grippers=wider, targets={"grippers": ["yumi"]})
    assert refused.returncode == 1
    assert "'yumi' opens 0.06 m in the settings, but 0.05 m in" in refused.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["config.yaml"]
