import pytest
import trimesh

from egad.stages.postprocess import from_folder


@pytest.fixture
def scans(tmp_path):
    for side, name in enumerate(["can", "mug", "bowl"], start=1):
        (tmp_path / name / "scan").mkdir(parents=True)
        trimesh.creation.box([side] * 3).export(tmp_path / name / "scan" / "mesh.ply")
    return tmp_path


def test_a_pattern_finds_and_names_the_meshes_of_sub_folders(scans):
    sources, known = from_folder(scans, "cm", 0, 1, "*/scan/mesh.ply")
    assert known.empty
    sides = {name: load().extents[0] for name, load in sources.items()}
    assert sides == pytest.approx({"can": 0.01, "mug": 0.02, "bowl": 0.03})


def test_every_mesh_is_in_one_shard(scans):
    shards = [set(from_folder(scans, "m", shard, 4, "**/*.ply")[0]) for shard in range(4)]
    assert sorted(name for shard in shards for name in shard) == [
        *("bowl-scan-mesh", "can-scan-mesh", "mug-scan-mesh")
    ]
