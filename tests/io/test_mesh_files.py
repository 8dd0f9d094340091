"""Every file of `mesh_files.py` gives the right solid, or is refused with the right reason."""

import lib3mf
import numpy as np
import pytest
import trimesh
from mesh_files import CASES

from egad.errors import RejectedError
from egad.io import read_mesh

READ = [name for name, case in CASES.items() if not case.refusal]
REFUSED = [name for name, case in CASES.items() if case.refusal]


def read(folder, name):
    (folder / name).write_bytes(CASES[name].data)
    return read_mesh(folder / name, CASES[name].units)


@pytest.mark.parametrize("name", READ)
def test_files_give_the_solid_that_they_hold(tmp_path, name):
    case, mesh = CASES[name], read(tmp_path, name)
    rough = 0.01 if "int8" in name else 1e-4
    assert 1000 * mesh.extents == pytest.approx(case.size, rel=rough)
    if case.volume is not None:
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert 1e9 * mesh.volume == pytest.approx(case.volume, rel=3 * rough)


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_right_is_refused_by_name(tmp_path, name):
    with pytest.raises(RejectedError, match=CASES[name].refusal) as found:
        read(tmp_path, name)
    assert len(str(found.value)) < 200


def lib3mf_volume(path):
    """Volume of all that is built, mm3, as the reference implementation of 3MF reads it."""
    model = lib3mf.get_wrapper().CreateModel()
    model.QueryReader("3mf").ReadFromFile(str(path))
    items, total = model.GetBuildItems(), 0.0
    while items.MoveNext():
        item = items.GetCurrent()
        total += lib3mf_part(model, item.GetObjectResource(), fields(item.GetObjectTransform()))
    metres = {"MicroMeter": 1e-6, "MilliMeter": 1e-3, "CentiMeter": 1e-2, "Meter": 1.0}
    metres |= {"Inch": 0.0254, "Foot": 0.3048}
    return total * (1000 * metres[model.GetUnit().name]) ** 3


def fields(transform):
    return np.array([list(row) for row in transform.Fields]).reshape(4, 3)


def lib3mf_part(model, part, matrix):
    number = part.GetResourceID()
    if part.IsMeshObject():
        found = model.GetMeshObjectByID(number)
        if found.GetType().name != "Model":
            return 0.0
        vertices = np.array([list(each.Coordinates) for each in found.GetVertices()])
        faces = np.array([list(each.Indices) for each in found.GetTriangleIndices()])
        solid = trimesh.Trimesh(vertices, faces, process=False)
        return abs(float(solid.volume * np.linalg.det(matrix[:3])))
    parts = model.GetComponentsObjectByID(number)
    every = [parts.GetComponent(k) for k in range(parts.GetComponentCount())]
    return sum(
        lib3mf_part(
            model,
            each.GetObjectResource(),
            np.vstack(
                [fields(each.GetTransform())[:3] @ matrix[:3], matrix[3]]  # place adds no volume
            ),
        )
        for each in every
    )


# An attribute that slicers write, and an encoding that the specification allows.
NOT_IN_LIB3MF = ("not_printed.3mf", "utf16.3mf")


@pytest.mark.parametrize(
    "name", [name for name in READ if name.endswith(".3mf") and name not in NOT_IN_LIB3MF]
)
def test_the_reference_implementation_reads_the_same_from_3mf(tmp_path, name):
    mesh = read(tmp_path, name)
    assert 1e9 * mesh.volume == pytest.approx(lib3mf_volume(tmp_path / name), rel=1e-5)


# What trimesh reads wrong or not at all.
ONLY_OURS = ("normalized", "sparse", "instanced", "fan", "many_primitives")
ONLY_OURS += ("hidden",)


@pytest.mark.parametrize(
    "name", [n for n in READ if n.endswith(".glb") and not any(word in n for word in ONLY_OURS)]
)
def test_trimesh_reads_the_same_from_glb_with_y_up(tmp_path, name):
    mesh = read(tmp_path, name)
    other = trimesh.load_mesh(tmp_path / name)
    scale = 1000 if CASES[name].units == "mm" else 1
    low, high = other.bounds / scale
    assert mesh.bounds[0] == pytest.approx([low[0], -high[2], low[1]], abs=1e-7)
    assert mesh.bounds[1] == pytest.approx([high[0], -low[2], high[1]], abs=1e-7)
    assert mesh.area == pytest.approx(other.area / scale**2, rel=1e-5)
