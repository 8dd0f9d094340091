"""What a GLB file promises, checked before memory is taken for it."""

import itertools
import json
import struct
from collections import Counter
from collections.abc import Mapping
from typing import Any

from egad.errors import RejectedError
from egad.exchange.bounds import MOST_ITEMS, MOST_PARTS, MOST_UNPACKED, within

JSON = 0x4E4F534A  # kind of the part of a file that has its structure


def check_glb(data: bytes) -> None:
    """Look through a GLB file, see `egad.exchange.promises.check_promises`."""
    tree = _structure(data)
    _check_buffers(tree, len(data))
    counts = [accessor["count"] for accessor in tree.get("accessors", [])]
    _check_nodes(tree, counts)


def only_positions(data: bytes) -> bytes:
    """A GLB file with nothing of its meshes but vertices and faces.

    Every other attribute would be copied for each part that has it.
    """
    tree = _structure(data)
    for mesh in tree.get("meshes", []):
        mesh["primitives"] = [
            {name: part[name] for name in ("mode", "indices") if name in part}
            | {"attributes": {"POSITION": part["attributes"]["POSITION"]}}
            for part in mesh["primitives"]
        ]
    text = json.dumps(tree).encode()
    rest = data[20 + struct.unpack_from("<I", data, 12)[0] :]
    sizes = struct.pack("<III", 20 + len(text) + len(rest), len(text), JSON)
    return data[:8] + sizes + text + rest


def _structure(data: bytes) -> dict[str, Any]:
    length, kind = struct.unpack_from("<II", data, 12)
    within(length, MOST_UNPACKED // 16, "bytes of structure")
    if kind != JSON:
        raise RejectedError("its structure is not where it should be")
    tree: dict[str, Any] = json.loads(data[20 : 20 + length])
    return tree


def _check_buffers(tree: Mapping[str, Any], size: int) -> None:
    """What the file holds, and how often it is used."""
    for buffer in [*tree.get("buffers", []), *tree.get("images", [])]:
        if not buffer.get("uri", "data:").startswith("data:"):
            raise RejectedError("it names another file; only what is in the file is read")
    views, accessors = tree.get("bufferViews", []), tree.get("accessors", [])
    within(sum(view["byteLength"] for view in views), 2 * size, "bytes in views of the file")
    for accessor in accessors:
        within(accessor["count"], 3 * MOST_ITEMS, "values of one kind")
    within(sum(map(_size, accessors)), 4 * MOST_UNPACKED, "bytes of values")
    bare = [accessor["count"] for accessor in accessors if "bufferView" not in accessor]
    within(sum(bare), MOST_ITEMS, "values that are not in the file")
    seen = Counter(accessor.get("bufferView") for accessor in accessors)
    sizes = {number: view["byteLength"] for number, view in enumerate(views)}
    shared = sum(sizes.get(view, 0) for view in seen.elements())
    within(shared, 64 * size, "bytes in views of the file, each as often as it is used")


def _size(accessor: Mapping[str, Any]) -> int:
    """Bytes of its values, which may overlap in the file."""
    width = {5120: 1, 5121: 1, 5122: 2, 5123: 2}.get(accessor["componentType"], 4)
    parts = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}.get(accessor["type"], 16)
    return int(accessor["count"]) * width * parts


def _check_nodes(tree: Mapping[str, Any], counts: list[int]) -> None:
    """Meshes, and how often they are placed."""
    nodes = tree.get("nodes", [])
    meshes = [mesh["primitives"] for mesh in tree.get("meshes", [])]
    placed = [*meshes, *(meshes[node["mesh"]] for node in nodes if "mesh" in node)]
    primitives = list(itertools.chain.from_iterable(placed))
    within(len(nodes) + len(primitives), MOST_PARTS, "nodes and placed parts")
    scenes = tree.get("scenes", [])
    roots = scenes[tree.get("scene", 0)].get("nodes", []) if scenes else []
    links = [*roots, *itertools.chain.from_iterable(node.get("children", []) for node in nodes)]
    if len(set(links)) < len(links):
        raise RejectedError("a node hangs from two others")
    items = sum(
        counts[primitive["attributes"]["POSITION"]]
        + (counts[primitive["indices"]] if "indices" in primitive else 0)
        for primitive in primitives
    )
    within(items, 4 * MOST_ITEMS, "vertices and corners of faces")
