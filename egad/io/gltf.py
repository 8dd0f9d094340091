"""GLB files (binary glTF 2.0): read, the triangles of the default scene; and written.

Source: Khronos Group, glTF 2.0 Specification; extensions KHR_mesh_quantization,
KHR_node_visibility and EXT_mesh_gpu_instancing.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.files import atomic_output
from egad._util.input_limits import MAX_FACES, MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.io.polygons import Content, check_corners, fan_triangles, strip_triangles

Json = dict[str, Any]

# glTF is Y up. (x, y, z) of a mesh, which is Z up, is (x, z, -y) of the file.
TO_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
INSTANCING, DRACO = "EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression"
VISIBILITY = "KHR_node_visibility"
READ = ("KHR_mesh_quantization", INSTANCING, VISIBILITY)
LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp")  # no shape
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES, STRIP, FAN = 4, 5, 6
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963  # numbers of OpenGL, which glTF uses
GREY_LINEAR = (0.48, 0.51, 0.57)  # linear RGB
ROUGHNESS = 0.7  # of a matte surface


def parse_glb(data: bytes) -> Content:
    """Read a GLB file, turned to have z up, without materials, textures and animations."""
    document, binary = _chunks(data)
    for name in document.get("extensionsRequired", []):
        if name not in READ and not str(name).startswith(LOOKS):
            raise RejectedError(f"it needs the extension {name}, which is not supported")
    try:
        return _content(document, binary)
    except KeyError as error:
        raise RejectedError(f"it is damaged: it has no {error.args[0]}") from error
    except IndexError as error:
        raise RejectedError("it is damaged: it refers to something that is missing") from error


def _content(document: Json, binary: bytes) -> Content:
    vertices, faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    for number, matrix in _placed_meshes(document, binary):
        for primitive in document["meshes"][number]["primitives"]:
            points, corners = _triangles(document, binary, primitive)
            if np.linalg.det(matrix[:3, :3]) < 0:
                corners = corners[:, ::-1]
            vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
            faces.append(corners + count)
            count += len(points)
            check_at_most(count, MAX_VERTICES, "vertices")
            check_at_most(sum(map(len, faces)), MAX_FACES, "faces")
    return Content(np.concatenate(vertices) @ TO_Y_UP, np.concatenate(faces))


def _chunks(data: bytes) -> tuple[Json, bytes]:
    """The document and the binary chunk."""
    if data[:4] != b"glTF":
        raise RejectedError("it does not start with `glTF`")
    version, length = (int.from_bytes(data[k : k + 4], "little") for k in (4, 8))
    if version != 2:
        raise RejectedError(f"glTF version {version} is not supported, only 2")
    if length > len(data):
        raise RejectedError("it is truncated")
    size = int.from_bytes(data[12:16], "little")
    start = 20 + size
    held = int.from_bytes(data[start : start + 4], "little")
    try:
        document = json.loads(data[20:start])
    except ValueError as error:  # of syntax or encoding
        raise RejectedError("it is damaged: its document is not JSON") from error
    if not isinstance(document, dict):
        raise RejectedError("its document is not an object")
    return document, data[start + 8 : start + 8 + held]


def _placed_meshes(document: Json, binary: bytes) -> Iterator[tuple[int, Floats]]:
    """The visible meshes of the default scene, and where each stands: (4, 4)."""
    nodes = document.get("nodes", [])
    waiting = [(number, np.eye(4)) for number in reversed(_roots(document))]
    seen = set[int]()
    while waiting:
        number, above = waiting.pop()
        if number in seen:
            raise RejectedError(f"the node {number} has two parents, or is below itself")
        seen.add(number)
        node = nodes[number]
        if not node.get("extensions", {}).get(VISIBILITY, {}).get("visible", True):
            continue
        matrix = above @ _matrix(node)
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]
        if "mesh" in node:
            _check_rigid(document, node)
            for instance in _instances(document, binary, node):
                yield node["mesh"], matrix @ instance


def _roots(document: Json) -> list[int]:
    """The nodes of the default scene; without scenes, all nodes that have no parent."""
    if scenes := document.get("scenes"):
        return list(scenes[document.get("scene") or 0].get("nodes", []))
    nodes = document.get("nodes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    return [number for number in range(len(nodes)) if number not in below]


def _check_rigid(document: Json, node: Json) -> None:
    """Refuse shapes that bones or weights bend."""
    mesh = document["meshes"][node["mesh"]]
    if "skin" in node:
        raise RejectedError("it has a skin, a shape that bones bend; export the shape itself")
    if any(node.get("weights", mesh.get("weights", []))):
        raise RejectedError("it has morph targets in use; export the shape itself")


def _matrix(node: Json) -> Floats:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    shift, turn = node.get("translation", [0, 0, 0]), node.get("rotation", [0, 0, 0, 1])
    return _transforms(shift, turn, node.get("scale", [1, 1, 1]))


def _transforms(shift: Any, turn: Any, scale: Any) -> Floats:  # noqa: ANN401 (of JSON or arrays)
    """The matrix of a translation (3,), a quaternion x, y, z, w (4,) and scales (3,)."""
    x, y, z, w = np.asarray(turn, dtype=np.float64)
    matrix: Floats = trimesh.transformations.quaternion_matrix([w, x, y, z])
    matrix[:3, :3] *= np.asarray(scale, dtype=np.float64)
    matrix[:3, 3] = shift
    return matrix


def _instances(document: Json, binary: bytes, node: Json) -> list[Floats]:
    """Where the copies of the mesh of a node stand: (4, 4) each."""
    copies = node.get("extensions", {}).get(INSTANCING)
    if copies is None:
        return [np.eye(4)]
    found = {
        name: _values(document, binary, accessor) for name, accessor in copies["attributes"].items()
    }
    if not found:
        raise RejectedError(f"{INSTANCING} does not say where the copies stand")
    count = len(next(iter(found.values())))
    shifts = found.get("TRANSLATION", np.zeros((count, 3)))
    turns = found.get("ROTATION", np.tile([0.0, 0, 0, 1], (count, 1)))
    scales = found.get("SCALE", np.ones((count, 3)))
    return [_transforms(*each) for each in zip(shifts, turns, scales, strict=True)]


def _triangles(document: Json, binary: bytes, primitive: Json) -> tuple[Floats, Ints]:
    """Vertices and faces of a primitive; no faces for points and lines."""
    points = _values(document, binary, primitive["attributes"]["POSITION"])
    if DRACO in primitive.get("extensions", {}) and not points.any():
        raise RejectedError(f"it needs the extension {DRACO}, which is not supported")
    if "indices" in primitive:
        corners = _values(document, binary, primitive["indices"]).ravel().astype(np.int64)
    else:
        corners = np.arange(len(points))
    check_corners(corners, len(points))
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES:
        if len(corners) % 3:
            raise RejectedError("the number of corners of its triangles is not a multiple of 3")
        return points, corners.reshape(-1, 3)
    if mode == STRIP:
        return points, strip_triangles(corners)
    if mode == FAN:
        return points, fan_triangles(corners)
    return points, np.empty((0, 3), np.int64)


def _values(document: Json, binary: bytes, number: int) -> Floats:
    """The values of an accessor, (n, width): whole numbers as they are, or as fractions."""
    accessor = document["accessors"][number]
    count, width = accessor["count"], WIDTHS[accessor["type"]]
    check_at_most(count, 3 * MAX_FACES, "values")
    kind = _component(accessor)
    if "bufferView" in accessor:
        values = _array(document, binary, accessor, kind, count, width).copy()
    else:
        values = np.zeros((count, width), kind)
    if sparse := accessor.get("sparse"):
        which = sparse["indices"]
        places = _array(document, binary, which, _component(which), sparse["count"], 1).ravel()
        values[places] = _array(document, binary, sparse["values"], kind, sparse["count"], width)
    if not accessor.get("normalized") or kind.kind == "f":
        return values.astype(np.float64)
    return np.maximum(values.astype(np.float64) / np.iinfo(kind).max, -1.0)


def _component(part: Json) -> np.dtype:
    """The type of the numbers of an accessor, or of the indices of its sparse part."""
    number = part["componentType"]
    if number not in COMPONENTS:
        raise RejectedError(f"it is damaged: the component type {number} does not exist")
    return np.dtype("<" + COMPONENTS[number])


def _array(
    document: Json, binary: bytes, part: Json, kind: np.dtype, count: int, width: int
) -> np.ndarray:
    """Numbers of a buffer view, (count, width), that begin where a part of an accessor says."""
    view = document["bufferViews"][part["bufferView"]]
    buffer = document["buffers"][view["buffer"]]
    if packed := [name for name in view.get("extensions", {}) if "meshopt" in name]:
        raise RejectedError(f"it needs the extension {packed[0]}, which is not supported")
    if "uri" in buffer or view["buffer"] != 0:
        raise RejectedError("its shapes are in another file, which is not read")
    start = view.get("byteOffset", 0) + part.get("byteOffset", 0)
    tight = kind.itemsize * width
    stride = view.get("byteStride") or tight
    within = part.get("byteOffset", 0) + stride * (count - 1) + tight
    if count < 1 or stride < tight or within > view["byteLength"] or start < 0:
        raise RejectedError("it is truncated: a buffer view does not hold all of its values")
    if start + stride * (count - 1) + tight > len(binary):
        raise RejectedError("it is truncated: its binary chunk is too short")
    return np.ndarray((count, width), kind, binary, start, (stride, kind.itemsize))


def write_glb(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a GLB file, metres, matte gray with flat faces; its node has the name of the file."""
    material = trimesh.visual.material.PBRMaterial(
        name="grey",
        baseColorFactor=(*GREY_LINEAR, 1.0),
        metallicFactor=0.0,
        roughnessFactor=ROUGHNESS,
    )
    turned = trimesh.Trimesh(
        np.asarray(mesh.vertices) @ TO_Y_UP.T,
        mesh.faces,
        process=False,
        visual=trimesh.visual.TextureVisuals(material=material),
    )
    scene = trimesh.Scene()
    scene.add_geometry(turned, node_name=path.stem, geom_name=path.stem)
    data = scene.export(file_type="glb", tree_postprocessor=_name_targets)
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)


def _name_targets(document: dict[str, Any]) -> None:
    """Say which buffer views hold vertices and which indices, as glTF recommends."""
    (mesh,) = document["meshes"]
    (primitive,) = mesh["primitives"]
    for accessor, target in (
        (primitive["attributes"]["POSITION"], ARRAY_BUFFER),
        (primitive["indices"], ELEMENT_ARRAY_BUFFER),
    ):
        view = document["accessors"][accessor]["bufferView"]
        document["bufferViews"][view]["target"] = target
