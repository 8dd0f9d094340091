"""`egad benchmark` clears tables by the rules that its option names."""

import pytest
import trimesh
import yaml
from commands import egad

from egad.tables import parquet
from egad.tables.clutter import CLUTTER


@pytest.fixture
def run(tmp_path, monkeypatch):
    """The command with two boxes and a detector that proposes nothing: what it says."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "meshes").mkdir()
    for number in range(2):
        box = trimesh.creation.box((0.03, 0.04, 0.05 + 0.01 * number))
        box.export(tmp_path / f"meshes/box{number}.obj")
    (tmp_path / "mine.py").write_text("def nothing(_view, _gripper, _rng):\n    return []\n")
    few = {"scenes": ["packed"], "rounds": 1, "objects": 2}
    (tmp_path / "few.yaml").write_text(yaml.safe_dump({"clutter": few}))
    common = "benchmark mine.py --objects meshes --units m --config few.yaml --jobs 1"
    return lambda protocol: egad(*common.split(), "--protocol", protocol)


def test_the_protocol_is_printed_and_kept(run, tmp_path):
    done = run("edgegrasp")
    assert done.returncode == 0, done.stderr
    assert "protocol: edgegrasp" in done.stdout
    table = parquet.read(tmp_path / "benchmark/mine.parquet", CLUTTER)
    assert table["protocol"].tolist() == ["edgegrasp"] * 3  # it skips twice
    assert table["noise"].unique().tolist() == ["points"]


def test_another_name_is_refused(run):
    text = run("gpd").stderr
    assert "--protocol: " in text
    assert "protocol is 'gpd'; allowed: egad, vgn, giga, edgegrasp, or a section with" in text
