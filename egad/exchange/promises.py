"""What a mesh file promises, checked before memory is taken for it.

Files of strangers may promise more than they hold, or little that unfolds to much: a header with
10^9 faces, a zip of zeros, parts made of parts. They may also name other files. None of this is
read; the message says which bound was passed.
"""

import io
import itertools
import json
import re
import struct
import zipfile
from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import Any

from lxml import etree

from egad.errors import RejectedError

MOST_BYTES = 1 << 30  # of a file
MOST_ITEMS = 4_000_000  # vertices, and as many faces
MOST_PARTS = 10_000  # bodies, nodes, instances
MOST_UNPACKED = 1 << 28  # bytes of all that is in a zip, and of the structure of a GLB file
# No entity is resolved and nothing is fetched.
XML = {"resolve_entities": False, "no_network": True, "load_dtd": False, "huge_tree": False}


def within(count: float, most: int, what: str) -> None:
    """Refuse more of something than is read.

    Raises:
        RejectedError: There is more, or less than none.
    """
    if not 0 <= count <= most:
        raise RejectedError(f"{count:,.0f} {what}; from 0 to {most:,} are read")


def check_promises(data: bytes, ending: str) -> None:
    """Look through a file for what would take more memory than it may.

    Args:
        data: Its content, at most `MOST_BYTES`.
        ending: Of its name: stl, ply, off, obj, glb or 3mf.

    Raises:
        RejectedError: It promises too much, or names other files.
        Exception: It is damaged; anything may be raised.
    """
    {
        "stl": _check_stl,
        "ply": _check_ply,
        "off": _check_off,
        "obj": _check_obj,
        "glb": _check_glb,
        "3mf": _check_3mf,
    }[ending](data)


def only_geometry(data: bytes) -> bytes:
    """An OBJ file with nothing but vertices and faces, and in these no more than the vertices.

    Materials, groups and comments would make parts that share all vertices, and name other files.
    """
    lines = data.replace(b"\r\n", b"\n").replace(b"\\\n", b"")
    kept = re.sub(rb"^(?![vf][ \t])[^\n]*\n?", b"", lines, flags=re.MULTILINE)
    return re.sub(rb"/[^\s]*", b"", kept.replace(b"\t", b" "))


def _check_stl(data: bytes) -> None:
    if len(data) >= 84 and 84 + 50 * int.from_bytes(data[80:84], "little") == len(data):
        within(int.from_bytes(data[80:84], "little"), MOST_ITEMS, "faces")
        return
    text = data.lower()
    within(text.count(b"vertex") / 3, MOST_ITEMS, "faces")
    within(text.count(b"endsolid"), MOST_PARTS, "bodies")


def _check_ply(data: bytes) -> None:
    head, found, _ = data[:100_000].partition(b"end_header")
    if not found:
        raise RejectedError("its header has no end")
    for name, count in re.findall(rb"^element\s+(\S+)\s+(\S+)", head, flags=re.MULTILINE):
        within(int(count), MOST_ITEMS, f"elements called {name.decode()}")
    if b"ascii" in head:
        within(data.count(b"\n") + data.count(b"\r"), 2 * MOST_ITEMS, "lines")


def _check_off(data: bytes) -> None:
    lines = data.count(b"\n") + data.count(b"\r")
    within(lines, 2 * MOST_ITEMS, "lines")
    counts = re.match(rb"\s*C?OFF\s+(\d+)\s+(\d+)", re.sub(rb"#[^\n]*", b"", data[:100_000]))
    if counts and int(counts[1]) + int(counts[2]) > lines:
        raise RejectedError("it is cut short")


def _check_obj(data: bytes) -> None:
    within(data.count(b"v ") + data.count(b"f "), 2 * MOST_ITEMS, "vertices and faces")


def _check_glb(data: bytes) -> None:
    length, kind = struct.unpack_from("<II", data, 12)
    within(length, MOST_UNPACKED // 16, "bytes of structure")
    if kind != 0x4E4F534A:
        raise RejectedError("its structure is not where it should be")
    tree = json.loads(data[20 : 20 + length])
    for buffer in [*tree.get("buffers", []), *tree.get("images", [])]:
        if not buffer.get("uri", "data:").startswith("data:"):
            raise RejectedError("it names another file; only what is in the file is read")
    views, accessors = tree.get("bufferViews", []), tree.get("accessors", [])
    within(sum(view["byteLength"] for view in views), 2 * len(data), "bytes in views of the file")
    for accessor in accessors:
        within(accessor["count"], 3 * MOST_ITEMS, "values of one kind")
    bare = [accessor["count"] for accessor in accessors if "bufferView" not in accessor]
    within(sum(bare), MOST_ITEMS, "values that are not in the file")
    seen = Counter(accessor.get("bufferView") for accessor in accessors)
    sizes = {number: view["byteLength"] for number, view in enumerate(views)}
    shared = sum(sizes.get(view, 0) for view in seen.elements())
    within(shared, 64 * len(data), "bytes in views of the file, each as often as it is used")
    _check_nodes(tree, [accessor["count"] for accessor in accessors])


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


def _check_3mf(data: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        within(len(entries), MOST_PARTS, "files in it")
        within(sum(entry.file_size for entry in entries), MOST_UNPACKED, "bytes unpacked")
        models = {
            entry.filename.strip("/"): _model(archive.read(entry))
            for entry in entries
            if entry.filename.lower().endswith(".model")
        }
    whole = {name: sum(own.values()) for name, (own, _, _) in models.items()}
    own: Counter[str] = Counter()
    parts: defaultdict[str, list[str]] = defaultdict(list)
    for held, components, _ in models.values():
        own.update(held)
        for parent, child, path in components:
            own[child] += whole.get(path, 0)
            parts[parent].append(child)
    within(sum(own.values()), 2 * MOST_ITEMS, "vertices and faces")
    items = [item for _, _, placed in models.values() for item in placed]
    within(len(items), MOST_PARTS, "placed objects")
    counted: dict[str, tuple[int, int]] = {}
    sizes = [_unfolded(item, own, parts, counted, ()) for item in items]
    within(sum(size for size, _ in sizes), 2 * MOST_ITEMS, "vertices and faces, as placed")
    within(sum(places for _, places in sizes), MOST_PARTS, "placed parts")


def _model(text: bytes) -> tuple[Counter[str], list[tuple[str, str, str]], list[str]]:
    """Vertices and faces by object; object, component and its file; what is placed."""
    held: Counter[str] = Counter()
    components, items = [], []
    tags = ("{*}object", "{*}item", "{*}model")
    for event, found in etree.iterparse(io.BytesIO(text), ("start", "end"), tag=tags, **XML):
        if found.getroottree().docinfo.doctype:
            raise RejectedError("its XML has a DOCTYPE, which 3MF forbids")
        name = etree.QName(found).localname
        if event == "end" and name == "item":
            items.append(found.attrib["objectid"])
        elif event == "end" and name == "object":
            key = found.attrib["id"]
            held[key] += sum(1 for _ in found.iter("{*}vertex", "{*}triangle"))
            for part in found.iter("{*}component"):
                paths = [value for word, value in part.attrib.items() if word.endswith("path")]
                components.append((key, part.attrib["objectid"], "".join(paths[:1]).strip("/")))
            found.clear()
    return held, components, items


def _unfolded(
    name: str,
    own: Mapping[str, int],
    parts: Mapping[str, list[str]],
    counted: dict[str, tuple[int, int]],
    above: tuple[str, ...],
) -> tuple[int, int]:
    """Vertices and faces, and parts, of an object with all that it is made of.

    Raises:
        RejectedError: It is made of itself.
    """
    if name in above or len(above) > 100:
        raise RejectedError("its objects are made of themselves, or nested too deep")
    if name not in counted:
        below = [
            _unfolded(part, own, parts, counted, (*above, name)) for part in parts.get(name, [])
        ]
        size, places = (sum(each[k] for each in below) for k in (0, 1))
        counted[name] = (own.get(name, 0) + size, max(places, 1))
    return counted[name]
