"""Objects as GLB: read by trimesh, and by hand after the specification of glTF 2.0."""

import json
import struct

import numpy as np
import pytest

from egad.io import read_mesh
from egad.io.gltf import write_glb


@pytest.fixture(scope="module")
def file(made, tmp_path_factory):
    folder = tmp_path_factory.mktemp("glb")
    write_glb(made.mesh, folder / "ell.glb")
    return folder / "ell.glb"


def chunks(data):
    """The JSON and the binary chunk of a GLB file."""
    magic, version, length = struct.unpack("<4sII", data[:12])
    assert (magic, version, length) == (b"glTF", 2, len(data))
    place, found = 12, {}
    while place < length:
        size, kind = struct.unpack("<I4s", data[place : place + 8])
        assert size % 4 == 0
        found[kind] = data[place + 8 : place + 8 + size]
        place += 8 + size
    return json.loads(found[b"JSON"]), found[b"BIN\0"]


def values(document, binary, accessor, kind):
    found = document["accessors"][accessor]
    view = document["bufferViews"][found["bufferView"]]
    start = view.get("byteOffset", 0) + found.get("byteOffset", 0)
    count = found["count"] * {"SCALAR": 1, "VEC3": 3}[found["type"]]
    return np.frombuffer(binary, kind, count, start)


def test_up_is_y_in_the_file_and_z_in_the_frame_of_the_mesh(file, made):
    document, binary = chunks(file.read_bytes())
    (node,) = document["nodes"]
    assert not {"matrix", "rotation", "translation", "scale"} & node.keys()
    (primitive,) = document["meshes"][node["mesh"]]["primitives"]
    x, y, z = values(document, binary, primitive["attributes"]["POSITION"], "<f4").reshape(-1, 3).T
    corners = values(document, binary, primitive["indices"], "<u4").reshape(-1, 3)
    np.testing.assert_array_equal(corners, made.mesh.faces)
    np.testing.assert_allclose(np.transpose([x, -z, y]), made.mesh.vertices, atol=1e-8)
    material = document["materials"][primitive["material"]]["pbrMetallicRoughness"]
    assert material["metallicFactor"] == 0
    assert "NORMAL" not in primitive["attributes"]  # faces are then flat, by the specification


def test_our_reader_gives_the_mesh_back_as_it_was(file, made):
    found = read_mesh(file, None)
    np.testing.assert_allclose(found.vertices, made.mesh.vertices, atol=1e-8)
    np.testing.assert_array_equal(found.faces, made.mesh.faces)
