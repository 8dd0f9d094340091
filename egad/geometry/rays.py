"""Exact ray casting: what a fingertip that moves along a line touches first."""

from typing import NamedTuple

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Floats = NDArray[np.float64]


GRAZING = 1e-4  # of the mesh's size: farther than this off, Embree's distance is the better one


class Hits(NamedTuple):
    """The first surface that each of n rays meets.

    Attributes:
        distances: (n,) along the ray, metres; infinite without a hit.
        normals: (n, 3) outward unit normals of the triangles; zeros without a hit.
        entering: (n,) whether the ray comes from outside; False without a hit.
    """

    distances: Floats
    normals: Floats
    entering: NDArray[np.bool_]


class RayCaster:
    """Casts many rays at one mesh.

    Embree finds the triangle in single precision, and without gaps between neighbours; the
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
        faces = np.array(mesh.faces, dtype=np.int32)
        self._corners = vertices[faces[:, 0]]
        self.normals = _normals(vertices[faces])
        self._scene = EmbreeScene(robust=True)
        TriangleMesh(self._scene, vertices.astype(np.float32), faces)

    def first_hits(self, origins: Floats, directions: Floats) -> Hits:
        """Meet the first triangle along each ray.

        Args:
            origins: (n, 3), metres.
            directions: (n, 3) unit vectors.
        """
        starts = (origins - self._origin) * self._scale
        found = self._scene.run(starts.astype(np.float32), directions.astype(np.float32), output=1)
        face = found["primID"].astype(np.int64)
        hit = face >= 0
        normals = np.where(hit[:, None], self.normals[face], 0.0)
        facing = np.einsum("nk,nk->n", normals, directions)
        height = np.einsum("nk,nk->n", normals, self._corners[face] - starts)
        rough = np.where(hit, found["tfar"], np.inf).astype(float)
        with np.errstate(divide="ignore", invalid="ignore"):
            exact = height / facing
            # a grazing ray may meet the plane far from the triangle
            near = np.abs(exact - rough) < GRAZING
        return Hits(np.where(near, exact, rough) / self._scale, normals, facing < 0)

    def obstructed(self, origins: Floats, directions: Floats, reach: float) -> NDArray[np.bool_]:
        """Whether each ray meets a triangle, from either side, within `reach` metres."""
        return np.asarray(self.first_hits(origins, directions).distances <= reach)


def _normals(triangles: Floats) -> Floats:
    """Unit normals of (n, 3, 3) triangles; zeros for those without area."""
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return np.asarray(np.divide(cross, length, out=np.zeros_like(cross), where=length > 0))
