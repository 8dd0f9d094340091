"""Ray casting by Embree: in single precision, and with exact distances of single meshes."""

from typing import Any, NamedTuple

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Flags = NDArray[np.bool_]

MISS = 1e30  # Embree gives 1e37 where a ray meets nothing
GRAZING = 1e-4  # of the mesh's size: farther than this off, Embree's distance is the better one
OBLIQUE = np.array([0.4359, 0.5931, 0.6769]) / np.linalg.norm([0.4359, 0.5931, 0.6769])


class Intersections(NamedTuple):
    """The first triangle that each of n rays meets.

    Attributes:
        faces: (n,) its number; -1 without a hit.
        distances: (n,) in lengths of the direction; infinite without a hit.
        coordinates: (n, 2) barycentric coordinates of the second and third corner.
        normals: (n, 3) of the triangle, of any length; zeros without a hit.
    """

    faces: NDArray[np.int64]
    distances: Singles
    coordinates: Singles
    normals: Singles


class TriangleScene:
    """Triangles that Embree casts rays at, in single precision.

    No ray slips through between neighbors.
    """

    def __init__(self, vertices: NDArray[Any], faces: NDArray[Any]) -> None:
        """Prepare triangles.

        Args:
            vertices: (n, 3).
            faces: (m, 3).
        """
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(
            self._scene,
            np.array(vertices, dtype=np.float32, order="C"),
            np.array(faces, dtype=np.int32, order="C"),
        )

    def intersections(self, origins: NDArray[Any], directions: NDArray[Any]) -> Intersections:
        """The first triangle along each ray; origins and directions (n, 3)."""
        found = self._scene.run(*_rays(origins, directions), query="INTERSECT", output=1)
        return Intersections(
            found["primID"].astype(np.int64),
            _infinite_where_missed(found["tfar"]),
            np.stack([found["u"], found["v"]], axis=1),
            found["Ng"],
        )

    def distances(self, origins: NDArray[Any], directions: NDArray[Any]) -> Singles:
        """Distances to the first triangle, (n,), in lengths of the direction; else infinite."""
        return _infinite_where_missed(
            self._scene.run(*_rays(origins, directions), query="DISTANCE")
        )

    def occluded(self, origins: NDArray[Any], directions: NDArray[Any]) -> Flags:
        """Whether each ray meets any triangle, (n,)."""
        found: Flags = self._scene.run(*_rays(origins, directions), query="OCCLUDED") == 0
        return found


def _rays(origins: NDArray[Any], directions: NDArray[Any]) -> tuple[Singles, Singles]:
    return (
        np.ascontiguousarray(origins, dtype=np.float32),
        np.ascontiguousarray(directions, dtype=np.float32),
    )


def _infinite_where_missed(distances: Singles) -> Singles:
    return np.where(distances < MISS, distances, np.float32(np.inf))


class Hits(NamedTuple):
    """The first surface that each of n rays meets.

    Attributes:
        distances: (n,) along the ray, metres; infinite without a hit.
        normals: (n, 3) outward unit normals of the triangles; zeros without a hit.
        entering: (n,) whether the ray comes from outside; False without a hit.
    """

    distances: Floats
    normals: Floats
    entering: Flags


class RayCaster:
    """Casts many rays at one mesh.

    Embree finds the triangle in single precision, and without gaps between neighbors; the
    distance is then computed from the triangle's plane in double precision.

    Attributes:
        mesh: The mesh.
        normals: (m, 3) outward unit normals of the triangles; zeros for those without area.
    """

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        """Prepare a mesh whose triangles wind outwards."""
        self.mesh = mesh
        low, high = np.asarray(mesh.bounds)
        self._origin = (low + high) / 2
        self._scale = 1 / float(np.max(high - low))
        vertices = (np.asarray(mesh.vertices) - self._origin) * self._scale
        faces = np.asarray(mesh.faces)
        self._corners = vertices[faces[:, 0]]
        self.normals = _normals(vertices[faces])
        self._scene = TriangleScene(vertices, faces)

    def first_hits(self, origins: Floats, directions: Floats) -> Hits:
        """Meet the first triangle along each ray.

        Args:
            origins: (n, 3), metres.
            directions: (n, 3) unit vectors.
        """
        starts = (origins - self._origin) * self._scale
        face, distances, *_ = self._scene.intersections(starts, directions)
        hit = face >= 0
        normals = np.where(hit[:, None], self.normals[face], 0.0)
        facing = np.einsum("nk,nk->n", normals, directions)
        height = np.einsum("nk,nk->n", normals, self._corners[face] - starts)
        rough = distances.astype(np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            exact = height / facing
            # a grazing ray may meet the plane far from the triangle
            near = np.abs(exact - rough) < GRAZING
        return Hits(np.where(near, exact, rough) / self._scale, normals, facing < 0)

    def obstructed(self, origins: Floats, directions: Floats, reach: float) -> Flags:
        """Whether each ray meets a triangle, from either side, within `reach` metres."""
        return np.asarray(self.first_hits(origins, directions).distances <= reach)

    def contains(self, points: Floats) -> Flags:
        """Whether each of n points lies in the mesh, which is closed: a ray first leaves it."""
        hits = self.first_hits(points, np.broadcast_to(OBLIQUE, points.shape))
        return np.asarray(np.isfinite(hits.distances) & ~hits.entering)


def _normals(triangles: Floats) -> Floats:
    """Unit normals of (n, 3, 3) triangles; zeros for those without area."""
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return np.asarray(np.divide(cross, length, out=np.zeros_like(cross), where=length > 0))
