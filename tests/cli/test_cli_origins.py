import pytest
import trimesh
from commands import egad

from egad.tables import parquet


@pytest.fixture
def scaled(tmp_path, monkeypatch):
    """A table of meshes that a command scaled."""
    monkeypatch.chdir(tmp_path)
    for name in "ab":
        trimesh.creation.box((40, 50, 60)).export(tmp_path / f"{name}.stl")
    words = ["a.stl", "b.stl", "--units", "mm", "--gripper", 0.05, "--jobs", 1]
    done = egad("rescale", *words, "--out", "all")
    assert done.returncode == 0, done.stderr
    return tmp_path / "all/scales.parquet"


def test_a_command_notes_what_it_read(scaled):
    noted = parquet.origin_of(scaled)
    assert [name for name, _ in noted["inputs"]] == ["../a.stl", "../b.stl"]
    assert (noted["stage"], noted["arguments"]) == ("rescale", {"units": "mm", "format": "obj"})


@pytest.mark.usefixtures("scaled")
def test_provenance_prints_a_tree():
    said = egad("provenance", "all/scales.parquet").stdout.splitlines()
    assert said[0].startswith("all/scales.parquet: rescale (format obj, units mm), settings ")
    assert said[1] == "└─ a.stl and 1 more: no provenance recorded"


def test_verify_tells_by_its_status_and_names_the_file(scaled):
    assert egad("verify", "all").returncode == 0
    data = bytearray(scaled.read_bytes())
    data[10] ^= 1
    scaled.write_bytes(data)
    done = egad("verify", "all")
    assert done.returncode == 1
    assert "all/scales.parquet: altered" in done.stdout
