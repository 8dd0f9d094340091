"""Multiresolution Reeb graphs, from the finest level to the coarsest.

Hilaga, Shinagawa, Kohmura, Kunii, "Topology Matching for Fully Automatic Similarity Estimation of
3D Shapes", SIGGRAPH 2001.
"""

import struct
import zlib
from dataclasses import dataclass

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints32
from egad._util.kernels import kernel
from egad.errors import RejectedError, UserError
from egad.geometry import (
    Triangulation,
    check_mesh,
    distinct_corners,
    face_areas,
    refine,
    triangulation,
)
from egad.measures.reeb.geodesics import edge_graph, even_integral, scan_integral
from egad.measures.reeb.parameters import Similarity
from egad.measures.reeb.ranges import Parts, cut, distinct, labels, outer_shell, unite

_HEADER = struct.Struct("<4sHHII")  # magic, version, ranges, nodes, links
_CHECKSUM = struct.Struct("<I")
BASE_COEFFICIENT = 0.005  # bases chosen by `scan` are sqrt(this * area) apart
_MAGIC, _VERSION = b"REEB", 1


@kernel()
def levels(
    parts: Parts, count: int
) -> tuple[Ints32, Ints32, Floats, Floats, Ints32, Ints32, Ints32, Ints32, Ints32]:
    """Build `count` levels, coarser nodes being connected unions of finer ones: `ReebGraph`."""
    most = count * len(parts.ranges)
    starts = np.zeros(count + 1, np.int32)
    ranges, parents = np.empty(most, np.int32), np.full(most, -1, np.int32)
    areas, lengths = np.empty(most), np.empty(most)
    links, linked = np.empty((count * len(parts.links), 2), np.int32), 0
    for level in range(count):
        start, end = starts[level], starts[level] + len(parts.ranges)
        starts[level + 1] = end
        ranges[start:end] = parts.ranges
        areas[start:end], lengths[start:end] = parts.areas, parts.lengths
        links[linked : linked + len(parts.links)] = parts.links + start
        linked += len(parts.links)
        if level < count - 1:
            parts, parent = _coarser(parts)
            parents[start:end] = parent + end
    nodes = starts[-1]
    inner = np.arange(starts[-2]).astype(np.int32)
    low, high = links[:linked, 0].copy(), links[:linked, 1].copy()
    child_starts, children = _rows(parents[: starts[-2]], inner, nodes)
    neighbor_starts, neighbors = _rows(
        np.concatenate((high, low)), np.concatenate((low, high)), nodes
    )
    return (
        starts,
        ranges[:nodes].copy(),
        areas[:nodes].copy(),
        lengths[:nodes].copy(),
        parents[:nodes].copy(),
        child_starts,
        children,
        neighbor_starts,
        neighbors,
    )


@kernel()
def _coarser(parts: Parts) -> tuple[Parts, Ints32]:
    """The next level, and which of its nodes each part belongs to."""
    roots = np.arange(len(parts.ranges)).astype(np.int32)
    within = np.empty(len(parts.links), np.bool_)
    for i, (low, high) in enumerate(parts.links):
        within[i] = parts.ranges[low] % 2 == 0
        if within[i]:
            unite(roots, low, high)
    parent, count = labels(roots)
    ranges, areas, lengths = np.empty(count, np.int32), np.zeros(count), np.zeros(count)
    for i, above in enumerate(parent):
        ranges[above] = parts.ranges[i] // 2
        areas[above] += parts.areas[i]
        lengths[above] += parts.lengths[i]
    across = parts.links[~within]
    links = distinct(parent[across[:, 0]], parent[across[:, 1]], count)
    return Parts(ranges, areas, lengths, links), parent


@kernel()
def _rows(owners: Ints32, items: Ints32, count: int) -> tuple[Ints32, Ints32]:
    """Items by their owners, in compressed rows; within a row they keep their order."""
    starts = np.zeros(count + 1, np.int32)
    for owner in owners:
        starts[owner + 1] += 1
    for row in range(count):
        starts[row + 1] += starts[row]
    place, result = starts.copy(), np.empty_like(items)
    for i, owner in enumerate(owners):
        result[place[owner]] = items[i]
        place[owner] += 1
    return starts, result


@dataclass(frozen=True, eq=False)
class ReebGraph:
    """Reeb graphs of one shape at several resolutions, the finest first.

    A node is a connected part of the surface within one range of its level; nodes are sorted by
    range. Areas and lengths sum to 1 over all nodes, and to the same over each level.
    """

    level_starts: Ints32  # (levels + 1,): first node of each level
    ranges: Ints32  # (n,)
    areas: Floats  # (n,)
    lengths: Floats  # (n,): of the interval of the function that a part spans
    parents: Ints32  # (n,): node of the next coarser level; -1 at the coarsest
    child_starts: Ints32  # (n + 1,): children of node i are children[child_starts[i]:...[i + 1]]
    children: Ints32
    neighbor_starts: Ints32  # (n + 1,): likewise
    neighbors: Ints32  # parts of the same level that a node touches; the lower range first


def extract(mesh: trimesh.Trimesh, settings: Similarity) -> ReebGraph:
    """The multiresolutional Reeb graph of mu of one connected shape, or `RejectedError`."""
    check_mesh(mesh)
    surface = refine(_checked(mesh), settings.vertices)
    areas = face_areas(surface)
    mu = _mu(surface, areas, settings)
    scaled = (mu - mu.min()) / mu.max() * settings.ranges
    parts = cut(surface, areas, np.minimum(scaled, np.nextafter(settings.ranges, 0)))
    return _graph(_sorted(parts, settings.ranges), settings.ranges)


def _checked(mesh: trimesh.Trimesh) -> Triangulation:
    """The outer shell with the vertices that it uses, scaled to a box of size 1."""
    vertices = np.asarray(mesh.vertices, np.float64).reshape(-1, 3)
    faces = distinct_corners(np.asarray(mesh.faces).reshape(-1, 3))
    if not len(faces):
        raise RejectedError("the mesh is empty")
    faces = outer_shell(vertices, faces)
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    vertices = vertices[used]
    size = np.ptp(vertices, axis=0).max()
    if not size > 0:
        raise RejectedError("the mesh has no extent")
    if not used.all():
        faces = (np.cumsum(used, dtype=np.int32) - 1)[faces]
    return triangulation(vertices / size, faces)


def _mu(surface: Triangulation, areas: Floats, settings: Similarity) -> Floats:
    total = areas.sum()
    if not total > 0:
        raise RejectedError("the mesh has no area")
    graph = edge_graph(surface, shortcuts=settings.bases == "even")
    mu: Floats
    if settings.bases == "even":
        mu = even_integral(graph, surface.vertices, surface.faces, areas, settings.base_count)
    else:
        radius = np.sqrt(BASE_COEFFICIENT * total)
        mu = scan_integral(graph, surface.faces, areas, radius)
    return mu


def _sorted(parts: Parts, ranges: int) -> Parts:
    """The parts by range, then size; areas and lengths become shares of one level."""
    order = np.lexsort((-parts.lengths, -parts.areas, parts.ranges))
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order))
    share = 1 / ranges.bit_length()
    return Parts(
        parts.ranges[order],
        parts.areas[order] * (share / parts.areas.sum()),
        parts.lengths[order] * (share / parts.lengths.sum()),
        distinct(rank[parts.links[:, 0]], rank[parts.links[:, 1]], len(order)),
    )


def _graph(parts: Parts, ranges: int) -> ReebGraph:
    return ReebGraph(*levels(parts, ranges.bit_length()))


def pack(graph: ReebGraph) -> bytes:
    """A graph as bytes: its finest level, from which all the others follow."""
    count = graph.level_starts[1]
    starts = graph.neighbor_starts[: count + 1]
    owners = np.repeat(np.arange(count), np.diff(starts))
    others = graph.neighbors[: starts[-1]]
    links = np.stack((owners, others), axis=1)[others > owners]
    ranges = 2 ** (len(graph.level_starts) - 2)
    data = b"".join(
        [
            _HEADER.pack(_MAGIC, _VERSION, ranges, count, len(links)),
            graph.areas[:count].astype("<f8").tobytes(),
            graph.lengths[:count].astype("<f8").tobytes(),
            graph.ranges[:count].astype("<i4").tobytes(),
            links.astype("<i4").tobytes(),
        ]
    )
    return data + _CHECKSUM.pack(zlib.crc32(data))


def unpack(data: bytes) -> ReebGraph:
    """The graph of `pack`, bit for bit; `UserError` for damaged bytes or another version."""
    if len(data) < _HEADER.size + _CHECKSUM.size or data[:4] != _MAGIC:
        raise UserError("This is not a packed Reeb graph.")
    _, version, ranges, nodes, links = _HEADER.unpack_from(data)
    if version != _VERSION:
        raise UserError(f"The packed Reeb graph has format {version}; {_VERSION} is expected.")
    body = memoryview(data)[: -_CHECKSUM.size]
    if _CHECKSUM.unpack(data[-_CHECKSUM.size :]) != (zlib.crc32(body),):
        raise UserError("The packed Reeb graph is damaged.")
    if len(body) != _HEADER.size + 20 * nodes + 8 * links:
        raise UserError("The packed Reeb graph is damaged.")
    floats = np.frombuffer(body, "<f8", 2 * nodes, _HEADER.size).astype(np.float64)
    offset = _HEADER.size + floats.nbytes
    ints = np.frombuffer(body, "<i4", nodes + 2 * links, offset).astype(np.int32)
    pairs = ints[nodes:].reshape(-1, 2)
    if (ints < 0).any() or (ints[:nodes] >= ranges).any() or (pairs >= nodes).any():
        raise UserError("The packed Reeb graph refers to parts that do not exist.")
    return _graph(Parts(ints[:nodes], floats[:nodes], floats[nodes:], pairs), ranges)
