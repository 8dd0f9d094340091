"""`egad benchmark` clears tables by the rules that its option names."""

import pytest
import trimesh
import yaml

from egad.cli import main
from egad.tables import parquet
from egad.tables.clutter import CLUTTER


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """The command with two boxes and a detector that proposes nothing: exit code and texts."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "meshes").mkdir()
    for number in range(2):
        box = trimesh.creation.box((0.03, 0.04, 0.05 + 0.01 * number))
        box.export(tmp_path / f"meshes/box{number}.obj")
    (tmp_path / "mine.py").write_text("def nothing(_view, _gripper, _rng):\n    return []\n")
    few = {"scenes": ["packed"], "rounds": 1, "objects": 2}
    (tmp_path / "few.yaml").write_text(yaml.safe_dump({"clutter": few}))
    common = "egad benchmark mine.py --objects meshes --units m --config few.yaml --jobs 1"

    def run(protocol):
        monkeypatch.setattr("sys.argv", [*common.split(), "--protocol", protocol])
        with pytest.raises(SystemExit) as stopped:
            main()
        return stopped.value.code, capsys.readouterr()

    return run


def test_the_protocol_is_printed_and_kept(run, tmp_path):
    code, said = run("edgegrasp")
    assert code == 0, said.err
    assert "protocol: edgegrasp" in said.out
    table = parquet.read(tmp_path / "benchmark/mine.parquet", CLUTTER)
    assert table["protocol"].tolist() == ["edgegrasp"] * 3  # it skips twice
    assert table["noise"].unique().tolist() == ["points"]


def test_another_name_is_refused(run):
    text, _ = run("gpd")
    assert "--protocol: " in text
    assert "protocol is 'gpd'; allowed: egad, vgn, giga, edgegrasp, or a section with" in text
