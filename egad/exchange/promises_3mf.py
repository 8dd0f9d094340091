"""What a 3MF file promises, checked before memory is taken for it."""

import codecs
import io
import re
import zipfile
from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import NamedTuple

from lxml import etree

from egad.errors import RejectedError
from egad.exchange.bounds import MOST_ITEMS, MOST_PARTS, MOST_UNPACKED, within

# No entity is resolved and nothing is fetched.
XML = {"resolve_entities": False, "no_network": True, "load_dtd": False, "huge_tree": False}
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


class Model(NamedTuple):
    """A part of a 3MF file.

    Attributes:
        held: Vertices and faces by object.
        whole: Vertices and faces, also of meshes outside of objects.
        components: Object, component and the part that this is in.
        placed: The objects of the build.
    """

    held: Counter[str]
    whole: int
    components: list[tuple[str, str, str]]
    placed: list[str]


def check_3mf(data: bytes) -> None:
    """Look through a 3MF file, see `egad.exchange.promises.check_promises`."""
    models = _models(data)
    own: Counter[str] = Counter()
    parts: defaultdict[str, list[str]] = defaultdict(list)
    for model in models.values():
        own.update(model.held)
        for parent, child, path in model.components:
            own[child] += models[path].whole if path in models else 0
            parts[parent].append(child)
    within(sum(own.values()), 2 * MOST_ITEMS, "vertices and faces")
    items = [item for model in models.values() for item in model.placed]
    within(len(items), MOST_PARTS, "placed objects")
    counted: dict[str, tuple[int, int]] = {}
    sizes = [_unfolded(item, own, parts, counted, ()) for item in items]
    within(sum(size for size, _ in sizes), 2 * MOST_ITEMS, "vertices and faces, as placed")
    within(sum(places for _, places in sizes), MOST_PARTS, "placed parts")


def _models(data: bytes) -> dict[str, Model]:
    """The models in a file and the parts that they name, whatever these are called."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = {entry.filename: entry for entry in archive.infolist()}
        within(len(archive.infolist()), MOST_PARTS, "files in it")
        size = sum(entry.file_size for entry in archive.infolist())
        within(size, MOST_UNPACKED, "bytes unpacked")
        if any(entry.compress_type not in PACKED for entry in archive.infolist()):
            raise RejectedError("it is packed in a way that 3MF does not allow")
        found: dict[str, Model] = {}
        wanted = [name for name in entries if _is_model(name.lower())]
        while wanted:
            name = wanted.pop()
            found[name] = _model(archive.read(entries[name]))
            named = {path for _, _, path in found[name].components}
            wanted += [path for path in named if path in entries and path not in found]
    return found


def _is_model(name: str) -> bool:
    return name.endswith(".model") or "3d/3dmodel.model" in name


def _check_text(text: bytes) -> None:
    """XML that holds what its bytes say: no entities, no characters of more bytes."""
    encoding = re.match(rb"[^>]*encoding\s*=\s*[\"']([^\"']*)", text[:1000])
    if b"\0" in text or (encoding and encoding[1].lower() not in (b"utf-8", b"us-ascii")):
        raise RejectedError("its XML is not UTF-8")
    if not text.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"<"):
        raise RejectedError("its XML is not UTF-8")
    if b"<!DOCTYPE" in text:
        raise RejectedError("its XML has a DOCTYPE, which 3MF forbids")
    within(text.count(b"<") + 2 * text.count(b"="), 8 * MOST_ITEMS, "elements and attributes")


def _model(text: bytes) -> Model:
    """What is in a part of a file."""
    _check_text(text)
    held: Counter[str] = Counter()
    components, items, whole = [], [], 0
    tags = ("{*}mesh", "{*}object", "{*}item")
    for _, found in etree.iterparse(io.BytesIO(text), ("end",), tag=tags, **XML):
        name = etree.QName(found).localname
        above = [
            etree.QName(each).localname for each in found.iterancestors("{*}mesh", "{*}object")
        ]
        if name in above:
            raise RejectedError(f"a {name} is in another")
        if name == "item":
            items.append(found.attrib["objectid"])
        elif name == "mesh":
            count = sum(1 for _ in found.iter("{*}vertex", "{*}triangle"))
            whole += count
            for parent in found.iterancestors("{*}object"):
                held[parent.attrib["id"]] += count
        else:
            for part in found.iter("{*}component"):
                paths = [value for word, value in part.attrib.items() if word.endswith("path")]
                path = "".join(paths[:1]).strip("/")
                components.append((found.attrib["id"], part.attrib["objectid"], path))
            found.clear()
    return Model(held, whole, components, items)


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
