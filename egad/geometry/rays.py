"""Ray casting by Embree: in single precision, and with exact distances of single meshes."""

from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, Ints, Ints32, Singles
from egad._util.kernels import kernel

NOTHING, MISS = 1e37, 1e30  # what Embree gives where a ray meets nothing, and what is no hit
HIT = [("primID", np.int64), ("tfar", np.float64), ("u", np.float32), ("v", np.float32)]
GRAZING = 1e-4  # of the mesh's size: if the distances differ by more, Embree's is the better one
OBLIQUE = np.array([0.4359, 0.5931, 0.6769]) / np.linalg.norm([0.4359, 0.5931, 0.6769])


def embree_scene(vertices: Singles, faces: Ints32) -> Any:  # noqa: ANN401 (untyped)
    """A scene of triangles, whose method `run` casts rays as that of embreex does."""
    try:
        from embreex.mesh_construction import TriangleMesh  # noqa: PLC0415 (there may be none)
        from embreex.rtcore_scene import EmbreeScene  # noqa: PLC0415
    except ModuleNotFoundError:
        return LibiglScene(vertices, faces)
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, vertices, faces)
    return scene


class LibiglScene:
    """Casts rays with the Embree of libigl, one at a time; the hits are those of embreex."""

    def __init__(self, vertices: Singles, faces: Ints32) -> None:
        from igl.embree import EmbreeIntersector  # noqa: PLC0415 (where embreex is, it need not be)

        a, b, c = np.moveaxis(vertices[faces], 1, 0)
        self._normals = np.concatenate([np.cross(b - a, c - a), np.zeros((1, 3), np.float32)])
        self._embree = EmbreeIntersector()
        self._embree.init(np.asfortranarray(vertices), np.asfortranarray(faces))

    def run(
        self, origins: Singles, directions: Singles, query: str, output: int = 0
    ) -> NDArray[Any] | dict[str, NDArray[Any]]:
        """Cast rays, origins and directions (n, 3): see `EmbreeScene.run` of embreex."""
        first = self._embree.intersectRay_first
        hits = np.array([first(*ray) for ray in zip(origins, directions, strict=True)], HIT)
        faces = hits["primID"]
        distances = np.where(faces < 0, NOTHING, hits["tfar"]).astype(np.float32)
        if query == "OCCLUDED":
            return np.where(faces < 0, -1, 0)
        if not output:
            return distances
        weights = {name: hits[name] for name in ("u", "v")}
        return {"primID": faces, "tfar": distances, "Ng": self._normals[faces], **weights}


class Intersections(NamedTuple):
    """The first triangle that each of n rays meets."""

    faces: Ints  # (n,) its number; -1 without a hit
    distances: Singles  # (n,) in units of the length of the direction; infinite without a hit
    coordinates: Singles  # (n, 2) barycentric coordinates of the second and third corner
    normals: Singles  # (n, 3) of the triangle, of any length; zeros without a hit


class TriangleScene:
    """Triangles that Embree casts rays at, in single precision, without gaps between neighbors."""

    def __init__(self, vertices: NDArray[Any], faces: NDArray[Any]) -> None:
        """Prepare triangles: vertices (n, 3), faces (m, 3)."""
        self._scene = embree_scene(
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
        """Distances, (n,), in units of the direction's length; infinite if no triangle is hit."""
        return _infinite_where_missed(
            self._scene.run(*_rays(origins, directions), query="DISTANCE")
        )

    def occluded(self, origins: NDArray[Any], directions: NDArray[Any]) -> Flags:
        """Whether each ray meets any triangle, (n,)."""
        return np.asarray(self._scene.run(*_rays(origins, directions), query="OCCLUDED") == 0)


def _rays(origins: NDArray[Any], directions: NDArray[Any]) -> tuple[Singles, Singles]:
    return (
        np.ascontiguousarray(origins, dtype=np.float32),
        np.ascontiguousarray(directions, dtype=np.float32),
    )


def _infinite_where_missed(distances: Singles) -> Singles:
    return np.where(distances < MISS, distances, np.float32(np.inf))


class Hits(NamedTuple):
    """The first surface that each of n rays meets."""

    distances: Floats  # (n,) along the ray, metres; infinite without a hit
    normals: Floats  # (n, 3) outward unit normals of the triangles; zeros without a hit
    entering: Flags  # (n,) whether the ray comes from outside; False without a hit


class RayCaster:
    """Casts rays at one mesh: Embree finds the triangle; its plane gives the distance in float64.

    Its `triangles`, (m, 3, 3), metres, have `areas` and outward unit `normals`, zeros without area.
    """

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        """Prepare a mesh whose triangles wind outwards."""
        self.mesh = mesh
        faces = np.asarray(mesh.faces)
        self.triangles: Floats = np.asarray(mesh.vertices)[faces]
        low, high = bounding_box(self.triangles)
        self._origin = (low + high) / 2
        self._scale = 1 / float(np.max(high - low))
        vertices = (np.asarray(mesh.vertices) - self._origin) * self._scale
        self._corners = vertices[faces[:, 0]]
        self.normals, areas = _normals_and_areas(vertices[faces])
        self.areas = areas / self._scale**2
        self._scene = TriangleScene(vertices, faces)

    def first_hits(self, origins: Floats, directions: Floats) -> Hits:
        """The first triangle along each ray; origins in metres and unit directions, (n, 3)."""
        starts = (origins - self._origin) * self._scale
        face, distances, *_ = self._scene.intersections(starts, directions)
        exact, normals, entering = _exact_hits(
            face, distances, self.normals, self._corners, starts, directions
        )
        return Hits(exact / self._scale, normals, entering)

    def obstructed(self, origins: Floats, directions: Floats, reach: float) -> Flags:
        """Whether each ray meets a triangle, from either side, within `reach` metres."""
        return np.asarray(self.first_hits(origins, directions).distances <= reach)

    def contains(self, points: Floats) -> Flags:
        """Whether each of n points lies in the closed mesh: a ray from it first leaves the mesh."""
        hits = self.first_hits(points, np.broadcast_to(OBLIQUE, points.shape))
        return np.asarray(np.isfinite(hits.distances) & ~hits.entering)


@kernel()
def _exact_hits(
    faces: Ints,
    distances: Singles,
    normals: Floats,
    corners: Floats,
    starts: Floats,
    directions: Floats,
) -> tuple[Floats, Floats, Flags]:
    """Distances to the planes of hit faces unless rays graze, normals, and if from outside."""
    exact = distances.astype(np.float64)
    found, entering = np.zeros((len(faces), 3)), np.zeros(len(faces), np.bool_)
    for i, face in enumerate(faces):
        if face < 0:
            continue
        facing = height = 0.0
        for k in range(3):
            found[i, k] = normals[face, k]
            facing += normals[face, k] * directions[i, k]
            height += normals[face, k] * (corners[face, k] - starts[i, k])
        entering[i] = facing < 0
        if facing != 0 and abs(height / facing - exact[i]) < GRAZING:
            exact[i] = height / facing
    return exact, found, entering


@kernel()
def bounding_box(triangles: Floats) -> tuple[Floats, Floats]:
    """The lowest and the highest corner of the box of (n, 3, 3) triangles, n > 0."""
    low, high = triangles[0, 0].copy(), triangles[0, 0].copy()
    for triangle in triangles:
        for corner in triangle:
            for k in range(3):
                low[k], high[k] = min(low[k], corner[k]), max(high[k], corner[k])
    return low, high


@kernel()
def _normals_and_areas(triangles: Floats) -> tuple[Floats, Floats]:
    """Unit normals of (n, 3, 3) triangles, zeros for those without area; and their areas."""
    normals, areas = np.zeros((len(triangles), 3)), np.empty(len(triangles))
    one, two, cross = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(triangles)):
        for k in range(3):
            one[k] = triangles[i, 1, k] - triangles[i, 0, k]
            two[k] = triangles[i, 2, k] - triangles[i, 0, k]
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            cross[k] = one[m] * two[n] - one[n] * two[m]
        length = np.sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2])
        areas[i] = length / 2
        if length > 0:
            for k in range(3):
                normals[i, k] = cross[k] / length
    return normals, areas
