"""Conversion to manifold3d and back: its solids are exact under union, intersection and cutting."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import manifold3d
import numpy as np
import trimesh
from trimesh.graph import connected_component_labels

from egad._util.arrays import Floats, Ints
from egad.errors import RejectedError
from egad.geometry.checks import OPEN, ROUNDING, cone_volumes
from egad.geometry.touching import separated

Solid = Any  # manifold3d.Manifold, which has no type information


def to_solid(vertices: Floats, faces: Ints) -> Solid:
    """The solid within closed surfaces that wind outwards, and may touch; see `is_solid`."""
    vertices, faces = separated(np.asarray(vertices), np.asarray(faces, dtype=np.int64))
    points = np.array(vertices, dtype=np.float64, order="C")  # copies: it rejects read-only ones
    triangles = np.array(faces, dtype=np.uint64, order="C")
    return manifold3d.Manifold(manifold3d.Mesh64(points, triangles))


def is_solid(solid: Solid) -> bool:
    """Whether every edge had two faces, wound consistently, and the solid is not empty."""
    return bool(solid.status() == manifold3d.Error.NoError and not solid.is_empty())


def solid_within(mesh: trimesh.Trimesh) -> Solid:
    """The solid in a closed surface, or `RejectedError`; of negative volume if it is inside out."""
    solid = to_solid(mesh.vertices, mesh.faces)
    if solid.status() != manifold3d.Error.NoError:
        raise RejectedError(OPEN)
    if solid.is_empty() or not abs(solid.volume()) > ROUNDING * float(mesh.extents.max()) ** 3:
        raise RejectedError("no volume")
    return solid


def wind_outwards(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy of a closed surface, wound outwards; raises the errors of `solid_within`."""
    found = mesh.copy()
    if solid_within(mesh).volume() < 0:
        found.invert()
    return found


def arrays(solid: Solid) -> tuple[Floats, Ints]:
    """Vertices (n, 3) and faces (m, 3) of a solid."""
    raw = solid.to_mesh64()
    vertices = np.array(np.asarray(raw.vert_properties)[:, :3], order="C")
    return vertices, np.asarray(raw.tri_verts).astype(np.int64)


class Bodies(NamedTuple):
    """The closed shells of a solid; those that touch in a vertex are of one body."""

    vertices: Floats  # (n, 3)
    faces: Ints  # (m, 3)
    shells: Ints  # of the faces, (m,)
    volumes: Floats  # of the shells, (k,); negative around a void
    groups: Ints  # numbers of the bodies of the shells, (k,)


def bodies(solid: Solid) -> Bodies:
    """The shells of a solid, in linear time, unlike `decompose` of manifold3d."""
    vertices, faces = arrays(solid)
    of_vertex = connected_component_labels(faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(vertices))
    shells = of_vertex[faces[:, 0]]
    volumes = np.bincount(shells, cone_volumes(vertices, faces)).astype(np.float64)
    groups = np.zeros(len(volumes), np.int64)
    if len(volumes) > 1:
        places = np.unique(vertices, axis=0, return_inverse=True)[1]
        links = np.column_stack([of_vertex, places + len(volumes)])
        groups = connected_component_labels(links, len(volumes) + len(vertices))[: len(volumes)]
    return Bodies(vertices, faces, shells, volumes, groups)


def to_mesh(solid: Solid) -> trimesh.Trimesh:
    """The surface of a solid."""
    return trimesh.Trimesh(*arrays(solid), process=False)


def union(solids: Iterable[Solid]) -> Solid:
    """All solids as one: where they overlap, only the outer surface stays."""
    return manifold3d.Manifold.batch_boolean(list(solids), manifold3d.OpType.Add)


def difference(
    meshes: Iterable[trimesh.Trimesh], others: Iterable[trimesh.Trimesh]
) -> trimesh.Trimesh:
    """The surface of closed surfaces without what lies in others; `RejectedError` if open."""

    def solid(mesh: trimesh.Trimesh) -> Solid:
        merged = mesh.copy()
        merged.merge_vertices()
        outwards = wind_outwards(merged)
        return to_solid(outwards.vertices, outwards.faces)

    return to_mesh(union(map(solid, meshes)) - union(map(solid, others)))


def box(low: Floats, high: Floats) -> Solid:
    """An axis-aligned box."""
    return manifold3d.Manifold.cube(tuple(high - low)).translate(tuple(low))


def joined(meshes: Iterable[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh of several that lie apart or touch."""
    parts = list(meshes)
    vertices, faces = [each.vertices for each in parts], [each.faces for each in parts]
    return trimesh.Trimesh(*trimesh.util.append_faces(vertices, faces), process=False)
