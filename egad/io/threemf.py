"""3MF files: the objects that are built, where they are built.

Modifiers and supports of slicers are left out, and negative volumes are cut out of the other
volumes of their object.

Source: 3MF Consortium, Core Specification 1.3 and Production Extension 1.1.
"""

import io
import zipfile
from collections.abc import Iterator, Sequence
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.input_limits import MAX_FACES, MAX_UNPACKED_BYTES, MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.geometry import difference
from egad.io.polygons import Content, check_corners
from egad.io.slicers import (
    CONFIGS,
    Volume,
    configured_volumes,
    cura_kind,
    marked_volumes,
    part_kind,
    sign_of,
    volume_sizes,
)
from egad.io.text import integers, reals, with_plain_nan
from egad.io.units import PRESCRIBED, UNIT_OF

MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing"
CORE, PRODUCTION = f"{MICROSOFT}/core/2015/02", f"{MICROSOFT}/production/2015/06"
TAG, PATH = f"{{{CORE}}}", f"{{{PRODUCTION}}}path"
KNOWN = (CORE, PRODUCTION, f"{MICROSOFT}/material/2015/02")  # the last has no shapes
MODEL_KIND = f"{MICROSOFT}/2013/01/3dmodel"
USUAL_MODEL = "3d/3dmodel.model"
UNITS = ("micron", "millimeter", "centimeter", "inch", "foot", "meter")
SHAPES = ("beamlattice", "booleanshape", "levelset", "displacementmesh")  # of extensions
SAME = np.eye(4)[:, :3]  # a transform (4, 3) of rows that are multiplied from the left


class _Placed(NamedTuple):
    vertices: Floats
    faces: Ints
    sign: int = 1  # see `egad.io.slicers.sign_of`


class _Leaf(NamedTuple):
    """A mesh object within an object that is built, and its volumes if it has several."""

    found: Element
    number: str
    matrix: Floats
    volumes: Sequence[Volume]


def parse_3mf(data: bytes) -> Content:
    """Read a 3MF file without support and what is not built, or raise `RejectedError`."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            check_at_most(
                sum(entry.file_size for entry in archive.infolist()),
                MAX_UNPACKED_BYTES,
                "bytes unpacked",
            )
            if any(entry.flag_bits & 1 for entry in archive.infolist()):
                raise RejectedError("it is encrypted")
            return _Package(archive).content()
    except zipfile.BadZipFile as error:
        raise RejectedError("it is not a complete zip archive") from error


class _Package:
    """The parts of a 3MF file, each parsed once; the case of their names does not matter."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._names = {name.lower(): name for name in archive.namelist()}
        self._start = self._start_path()
        self._models = dict[str, Element]()
        self._objects = dict[str, dict[str, Element]]()
        self._volumes = dict[str, list[Volume]]()  # of objects in the part that it starts with
        self._left_out = set[str]()
        self._total = [0, 0]  # vertices, faces

    def content(self) -> Content:
        """All that is built."""
        root = self._model(self._start)
        for name in (each for each in CONFIGS if each in self._names):
            self._volumes = configured_volumes(self._parsed(name)[0]) | self._volumes
        parts = list(self._built(root))
        if not parts and self._left_out:
            raise RejectedError(f"no faces: its objects are {', '.join(sorted(self._left_out))}")
        if not parts:
            raise RejectedError("no faces: nothing is built")
        starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
        faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
        vertices = np.concatenate([part.vertices for part in parts])
        stated = [unit for each in self._models.values() if (unit := _unit(each))]
        return Content(vertices, np.concatenate(faces), stated[0] if stated else None)

    def _start_path(self) -> str:
        """The path of the model part that the package is about, in small letters."""
        if "_rels/.rels" in self._names:
            for each in self._parsed("_rels/.rels")[0]:
                if each.get("Type") == MODEL_KIND and each.get("Target"):
                    return str(each.get("Target")).lstrip("/").lower()
        if USUAL_MODEL not in self._names:
            raise RejectedError("it has no model part")
        return USUAL_MODEL

    def _parsed(self, path: str) -> tuple[Element, dict[str, str]]:
        return _parsed(self._archive.read(self._names[path]))

    def _model(self, path: str) -> Element:
        if path not in self._models:
            if path not in self._names:
                raise RejectedError(f"its part {path} is missing")
            root, namespaces = self._parsed(path)
            if root.tag != f"{TAG}model":
                raise RejectedError(f"its part {path} is not a model")
            for prefix in root.get("requiredextensions", "").split():
                space = namespaces.get(prefix, prefix)
                if space not in KNOWN:
                    raise RejectedError(f"it needs the extension {space}, which is not supported")
            self._models[path] = root
            found = root.iterfind(f"{TAG}resources/{TAG}object")
            self._objects[path] = {str(each.get("id")): each for each in found}
        return self._models[path]

    def _built(self, root: Element) -> Iterator[_Placed]:
        unit = _unit(root)
        for item in root.iterfind(f"{TAG}build/{TAG}item"):
            if item.get("printable") == "0":
                self._left_out.add("not printable")
                continue
            volumes = self._volumes.get(str(item.get("objectid")), [])
            pieces = [
                piece
                for index, leaf in enumerate(self._leaves(self._start, unit, item, SAME, ()))
                for piece in self._pieces(leaf, part_kind(volumes, index, leaf.number))
            ]
            yield from _cut(pieces)

    def _leaves(
        self,
        path: str,
        unit: str | None,
        reference: Element,
        above: Floats,
        parents: tuple[tuple[str, str], ...],
    ) -> Iterator[_Leaf]:
        """The mesh objects of the object that an item or a component refers to."""
        path = reference.get(PATH, path).lstrip("/").lower()
        if (_unit(self._model(path)) or PRESCRIBED["3mf"]) != (unit or PRESCRIBED["3mf"]):
            raise RejectedError(f"its parts have different units: {path}")
        number = str(reference.get("objectid"))
        found = self._objects[path].get(number)
        if found is None:
            raise RejectedError(f"the object {number} is missing")
        if (path, number) in parents:
            raise RejectedError(f"the object {number} is a part of itself")
        matrix = _transform(reference) @ above[:3]
        matrix[3] += above[3]
        components = found.find(f"{TAG}components")
        if components is None:
            volumes = self._volumes.get(number, []) if path == self._start else []
            yield _Leaf(found, number, matrix, [each for each in volumes if each.first])
            return
        for each in components.iterfind(f"{TAG}component"):
            yield from self._leaves(path, unit, each, matrix, (*parents, (path, number)))

    def _pieces(self, leaf: _Leaf, kind: str | None) -> list[_Placed]:
        """What an object contributes, which is of a kind that a slicer names, if one does."""
        usual = leaf.found.get("type", "model")
        kind = kind if kind is not None else cura_kind(leaf.found)
        if usual != "model" and not kind:
            self._left_out.add(f"of type {usual}")
            return []
        if not (sign := self._sign(kind)):
            return []
        points, faces, marked = self._mesh(leaf)
        sizes = volume_sizes(leaf.volumes or marked, len(faces))
        signs = np.repeat([self._sign(kind) for kind, _ in sizes], [size for _, size in sizes])
        parts = [_Placed(points, faces[signs == each], each) for each in (1, -1)]
        return [each._replace(sign=sign) for each in _cut([p for p in parts if len(p.faces)])]

    def _sign(self, kind: str) -> int:
        """What a volume of some kind adds; that it is left out is noted."""
        if not (sign := sign_of(kind)):
            self._left_out.add(f"of the kind {kind}")
        return sign

    def _mesh(self, leaf: _Leaf) -> tuple[Floats, Ints, list[Volume]]:
        """Vertices and faces of an object, and the volumes that are noted within it."""
        mesh = leaf.found.find(f"{TAG}mesh")
        within = leaf.found if mesh is None else mesh
        others = [each for each in within if _local_name(each) in SHAPES and TAG not in each.tag]
        if mesh is None or others:
            name = _local_name(others[0]) if others else "nothing"
            raise RejectedError(f"an object has a shape of {name}, which is not supported")
        vertices = _attributes(mesh.findall(f"{TAG}vertices/{TAG}vertex"), ("x", "y", "z"))
        corners = _attributes(mesh.findall(f"{TAG}triangles/{TAG}triangle"), ("v1", "v2", "v3"))
        self._total[0] += len(vertices) // 3
        self._total[1] += len(corners) // 3
        check_at_most(self._total[0], MAX_VERTICES, "vertices")
        check_at_most(self._total[1], MAX_FACES, "faces")
        matrix = leaf.matrix
        points = reals(vertices, "a vertex").reshape(-1, 3) @ matrix[:3] + matrix[3]
        faces = integers(corners, "a triangle").reshape(-1, 3)
        check_corners(faces, len(points))
        outwards = faces[:, ::-1] if np.linalg.det(matrix[:3]) < 0 else faces
        return points, outwards, marked_volumes(mesh)


def _cut(pieces: list[_Placed]) -> list[_Placed]:
    """The solid pieces, without the negative volumes, which are cut out of them."""
    solid, negative = ([each for each in pieces if each.sign == sign] for sign in (1, -1))
    if not solid or not negative:
        return solid
    bodies, holes = (
        [trimesh.Trimesh(each.vertices, each.faces, process=False) for each in part]
        for part in (solid, negative)
    )
    try:
        mesh = difference(bodies, holes)
    except RejectedError as reason:
        raise RejectedError(f"it has a negative volume, but one is no solid: {reason}") from reason
    return [_Placed(np.asarray(mesh.vertices), np.asarray(mesh.faces))] if len(mesh.faces) else []


class _Tree(ElementTree.TreeBuilder):
    """Builds the elements of a file, and notes the `namespaces` of the root, by prefix."""

    def __init__(self) -> None:
        super().__init__()
        self.namespaces = dict[str, str]()
        self._started = False

    def start(self, tag: str, attributes: dict[str, str], /) -> Element:
        self._started = True
        return super().start(tag, attributes)

    def start_ns(self, prefix: str, uri: str) -> None:
        if not self._started:
            self.namespaces[prefix] = uri

    def doctype(self, *_: str | None) -> None:
        raise RejectedError("it has a document type, which is not allowed")


def _parsed(data: bytes) -> tuple[Element, dict[str, str]]:
    """The root of a file, and its namespaces by prefix."""
    tree = _Tree()
    parser = ElementTree.XMLParser(target=tree)  # noqa: S314 (no document type, no entities)
    try:
        parser.feed(with_plain_nan(data))
        return parser.close(), tree.namespaces
    except ElementTree.ParseError as error:
        raise RejectedError(f"it is damaged: {str(error)[:120]}") from error


def _local_name(element: Element) -> str:
    return element.tag.rpartition("}")[2]


def _unit(root: Element) -> str | None:
    name = root.get("unit")
    if name is not None and name not in UNITS:
        raise RejectedError(f"its unit is {name!r}; allowed in 3MF: {', '.join(UNITS)}")
    return None if name is None else UNIT_OF[name]


def _transform(element: Element) -> Floats:
    text = element.get("transform")
    if text is None:
        return SAME
    numbers = reals(text.encode().split(), "a transform")
    if len(numbers) != 12:
        raise RejectedError(f"a transform has {len(numbers)} numbers, not 12")
    return numbers.reshape(4, 3)


def _attributes(elements: list[Element], names: tuple[str, ...]) -> list[bytes]:
    return [element.get(name, "nothing").encode() for element in elements for name in names]
