import lib3mf
import numpy as np
import pytest
import trimesh

from egad.evalset.plate_files import PlacedMesh, write_3mf


@pytest.fixture
def plate(tmp_path):
    objects = {
        "A0": PlacedMesh(trimesh.creation.icosphere(subdivisions=2, radius=0.02), np.zeros(3)),
        'G<6>"&': PlacedMesh(
            trimesh.creation.box(extents=(0.01, 0.02, 0.03)), np.array([0.1, 0.05, 0])
        ),
    }
    path = tmp_path / "plate.3mf"
    write_3mf(objects, path, {"Title": "R & D"})
    return path, objects


def test_trimesh_reads_it_back_in_millimetres(plate):
    path, objects = plate
    scene = trimesh.load_scene(path)
    assert scene.units in ("mm", "millimeter")
    read = sorted(abs(mesh.volume) for mesh in scene.dump())
    assert read == pytest.approx(sorted(1e9 * placed.mesh.volume for placed in objects.values()))
    assert scene.bounds[1] == pytest.approx([105, 60, 20], abs=1e-3)


def test_same_bytes_every_time(plate, tmp_path):
    path, objects = plate
    write_3mf(objects, tmp_path / "again.3mf", {"Title": "R & D"})
    assert (tmp_path / "again.3mf").read_bytes() == path.read_bytes()


def strict_model(path):
    """What lib3mf reads in strict mode; any deviation from the specification is an error."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    return model


def test_strict_readers_find_named_solids_in_millimetres(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.02).apply_translation([0.02] * 3)
    box = trimesh.creation.box((0.01, 0.02, 0.03)).apply_translation([0.005, 0.01, 0.015])
    placed = {
        "A0": PlacedMesh(ball, np.array([0.005, 0.005, 0])),
        "G6": PlacedMesh(box, np.full(3, 0.0)),
    }
    write_3mf(placed, tmp_path / "plate.3mf", {"Title": "A plate", "Description": "A0 <1 & 2>"})
    model = strict_model(tmp_path / "plate.3mf")
    assert model.GetUnit() == type(model.GetUnit()).MilliMeter
    objects, names = model.GetMeshObjects(), []
    while objects.MoveNext():
        each = objects.GetCurrentMeshObject()
        names.append(each.GetName())
        assert each.IsManifoldAndOriented()
    assert names == ["A0", "G6"]
    assert model.GetMetaDataGroup().GetMetaDataCount() == 2
