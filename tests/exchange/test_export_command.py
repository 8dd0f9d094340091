import shutil
import subprocess
import sys

import h5py
import pytest
import yaml

GRIPPER = "yumi"


@pytest.fixture
def export(dataset, tmp_path):
    """Runs `egad export` on the dataset."""

    def run(style, out, folder=dataset):
        config = tmp_path / "config.yaml"
        config.write_text(yaml.safe_dump({"dexnet": {"field_size": 16}, "acronym": {"held": 0}}))
        code = "from egad.cli import main; main()"
        given = [folder, "--gripper", GRIPPER, "--format", style, "--out", out, "--config", config]
        return subprocess.run(
            [sys.executable, "-c", code, "export", *map(str, given)],
            check=False,
            capture_output=True,
            text=True,
        )

    return run


def test_a_database_is_made_of_a_folder(export, tmp_path):
    done = export("dexnet", tmp_path / "new" / "grasps.hdf5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "new" / "grasps.hdf5") as file:
        objects = file["datasets/tiny/objects"]
        assert list(objects) == ["A00_0", "B01_0", "C02_0"]
        assert objects["A00_0/sdf/data"].shape == (16, 16, 16)
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["grasps.hdf5"]


def test_acronym_files_take_no_folder_of_others(export, tmp_path):
    out = tmp_path / "files"
    for _ in range(2):  # the second time over its own files
        assert export("acronym", out).returncode == 0
    with h5py.File(out / "A00_0.h5") as file:
        values = file["grasps/qualities/egad"]
        assert (values["success"][()] == values["collision_free"][()]).all()
    (out / "thesis.txt").write_text("years of work")
    refused = export("acronym", out)
    assert refused.returncode == 1
    assert "would be lost" in refused.stderr
    assert (out / "thesis.txt").exists()


@pytest.mark.parametrize("style", ["dexnet", "acronym"])
def test_a_table_cut_short_leaves_no_export(export, dataset, tmp_path, style):
    broken = shutil.copytree(dataset, tmp_path / "broken")
    table = broken / "grasps" / f"{GRIPPER}.parquet"
    table.write_bytes(table.read_bytes()[:-20])
    done = export(style, tmp_path / "out", broken)
    assert done.returncode == 1
    assert f"{GRIPPER}.parquet: not a readable Parquet file" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
