"""How a solid comes to rest on a table: the faces of its hull that it rests on, and how often."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Ints
from egad._util.display import facts_html
from egad.errors import RejectedError
from egad.geometry.checks import check_mesh
from egad.geometry.mass import center_or_given

ROUNDING = 1e-9  # products of unit vectors differ by less, however they are added up


class StablePose(NamedTuple):
    """An object at rest on the table z = 0, its center of mass above the origin.

    The rotation about the vertical is arbitrary: it results from the smallest rotation that brings
    the resting face down.

    Attributes:
        probability: Probability that a drop in a random orientation, without bouncing, ends here.
        face: Indices of the vertices of the mesh at the corners of the resting face, ascending.
        normal: Outward normal of this face in the frame of the mesh, (3,).
        rotation: From the frame of the mesh to that of the table, (3, 3).
        height: Height of the center of mass above the table, in the unit of the mesh.
        margin: The least angle by which the table must be tilted for the object to topple, radians.
        center: Center of mass in the frame of the mesh, (3,).
    """

    probability: float
    face: Ints
    normal: Floats
    rotation: Floats
    height: float
    margin: float
    center: Floats

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {value}" for name, value in self._facts().items())
        return f"StablePose({facts})"

    def _repr_html_(self) -> str:
        return facts_html("StablePose", self._facts())

    def _facts(self) -> dict[str, str]:
        return {
            "probability": f"{100 * self.probability:.1f} %",
            "center of mass at height": f"{self.height:.4g}",
            "topples at": f"{np.degrees(self.margin):.1f}°",
            "corners of the resting face": str(len(self.face)),
        }

    @property
    def matrix(self) -> Floats:
        """The (4, 4) transform from the frame of the mesh to that of the table, a rigid one."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = [0, 0, self.height] - self.rotation @ self.center
        return matrix


class _Facets(NamedTuple):
    """The m flat faces of a hull, of one or more triangles each, and the edges between them."""

    normals: Floats
    heights: Floats
    solid_angles: Floats
    triangles: Ints  # (t, 3) vertices of the mesh: all triangles of the hull
    face: Ints  # (t,) of each
    start: Floats  # (k, 3) of the edges between two faces
    end: Floats
    owner: Ints  # (k,) the face whose outline the edge is part of, counterclockwise
    beyond: Ints  # (k,) the face behind it


def stable_poses(
    mesh: trimesh.Trimesh, center_of_mass: ArrayLike | None = None
) -> list[StablePose]:
    """The poses in which a solid can rest on a table, the most probable first.

    Args:
        mesh: A closed surface, in any unit; any surface if the center of mass is given, because
            then only its convex hull matters.
        center_of_mass: (3,) in the unit of the mesh; by default that of a solid of uniform density.

    Returns:
        At least one pose, with probabilities that add up to 1. `pose.matrix` is the (4, 4)
        transform from the frame of the mesh to that of the table: z points up, the table is at
        z = 0, and the center of mass is above the origin.

    Raises:
        RejectedError: The mesh is flat, or the center of mass is not inside its hull. Or the
            center of mass is not given, and the mesh is open or inside out.
        UserError: It is not a mesh, or the center of mass is not 3 finite numbers.

    Source: after Goldberg et al., Part pose statistics, 1999 (quasi-static estimate).
    """
    return resting_poses(mesh, center_or_given(mesh, center_of_mass))


def resting_poses(mesh: trimesh.Trimesh, center: Floats) -> list[StablePose]:
    """The poses of `stable_poses` about a center of mass, (3,), strictly inside the hull.

    An object lands on a face by its solid angle, then rolls over nearest edges, quasi-statically.
    """
    check_mesh(mesh)
    facets = _facets(np.asarray(mesh.vertices, dtype=np.float64), center)
    margins, target = _rolls(facets)
    chances = facets.solid_angles / facets.solid_angles.sum()
    for face in np.argsort(-facets.heights, kind="stable"):  # highest first: they roll downwards
        if target[face] != face:
            chances[target[face]] += chances[face]
            chances[face] = 0.0
    resting = np.flatnonzero((target == np.arange(len(target))) & (chances > 0))
    order = resting[np.argsort(-chances[resting], kind="stable")]
    return [
        StablePose(
            probability=float(chances[face]),
            face=np.unique(facets.triangles[facets.face == face]),
            normal=facets.normals[face],
            rotation=rotation_to_table(facets.normals[face]),
            height=float(facets.heights[face]),
            margin=float(margins[face]),
            center=center,
        )
        for face in order
    ]


def group_poses(poses: list[StablePose], angle: float) -> list[StablePose]:
    """Merge poses whose faces are turned by less than `angle`, radians, into the most probable."""
    kept: list[StablePose] = []
    normals, least = np.empty((len(poses), 3)), np.cos(angle)
    for pose in poses:
        close = np.flatnonzero(normals[: len(kept)] @ pose.normal > least - ROUNDING)
        place = next((k for k in close if kept[k].normal @ pose.normal > least), None)
        if place is None:
            normals[len(kept)] = pose.normal
            kept.append(pose)
        else:
            chance = kept[place].probability + pose.probability
            kept[place] = kept[place]._replace(probability=chance)
    return sorted(kept, key=lambda pose: -pose.probability)


def rotation_to_table(normal: Floats) -> Floats:
    """The rotation by the smallest angle that turns a unit vector to -z, (3, 3)."""
    axis = np.cross(normal, [0.0, 0.0, -1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(-normal[2])
    if sine == 0:
        return np.eye(3) if cosine > 0 else np.diag([1.0, -1.0, -1.0])
    return np.asarray(Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix())


def _facets(vertices: Floats, center: Floats) -> _Facets:
    try:
        hull = ConvexHull(vertices)
    except QhullError as error:
        raise RejectedError("flat: it has no hull to rest on") from error
    # Qhull merges faces that are flat to its precision and gives their triangles the same plane.
    planes, face = np.unique(hull.equations, axis=0, return_inverse=True)
    face = face.ravel()
    heights = -(planes[:, :3] @ center + planes[:, 3])
    if not heights.min() > 0:
        raise RejectedError("the center of mass is not inside the hull")
    triangles, neighbors = _outward(hull, vertices)
    angles = np.zeros(len(planes))
    np.add.at(angles, face, _solid_angles(vertices[triangles] - center))
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)  # 01, 12, 20
    behind = face[np.roll(neighbors, -2, axis=1)]  # a neighbor has the index of the opposite corner
    rim = behind != face[:, None]
    ends = vertices[sides[rim]] - center
    owner = np.broadcast_to(face[:, None], behind.shape)[rim]
    outlines = (ends[:, 0], ends[:, 1], owner, behind[rim])
    return _Facets(planes[:, :3], heights, angles, triangles, face, *outlines)


def _outward(hull: ConvexHull, vertices: Floats) -> tuple[Ints, Ints]:
    """The triangles of a hull, counterclockwise seen from outside, and their neighbors."""
    triangles, neighbors = hull.simplices.astype(np.int64), hull.neighbors.astype(np.int64)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    inward = _dot(np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    neighbors[inward] = neighbors[inward][:, ::-1]
    return triangles, neighbors


def _rolls(facets: _Facets) -> tuple[Floats, Ints]:
    """Tipping angle of each face, and the face that an object on it rolls to; itself if none."""
    normals, heights = facets.normals[facets.owner], facets.heights[facets.owner]
    foot = heights[:, None] * normals
    along = facets.end - facets.start
    length = np.maximum(np.linalg.norm(along, axis=1), np.finfo(np.float64).tiny)
    along = along / length[:, None]
    depth = _dot(foot - facets.start, np.cross(normals, along))  # of the foot within the outline
    place = np.clip(_dot(foot - facets.start, along), 0, length)
    away = np.linalg.norm(foot - facets.start - place[:, None] * along, axis=1)
    least = np.full(len(facets.heights), np.inf)
    np.minimum.at(least, facets.owner, depth)
    target = np.arange(len(facets.heights))
    falls = np.flatnonzero((depth < 0) & (facets.heights[facets.beyond] < heights))
    # The last of a face wins: the nearest edge, and of edges that meet there, the overstepped one.
    order = falls[np.lexsort((-depth[falls], -away[falls]))]
    target[facets.owner[order]] = facets.beyond[order]
    return np.arctan2(np.maximum(least, 0), facets.heights), target


def _solid_angles(triangles: Floats) -> Floats:
    """Solid angles of triangles seen from the origin (n,), after Van Oosterom and Strackee."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    volume = np.abs(_dot(a, np.cross(b, c)))
    flat = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
    return np.asarray(2 * np.arctan2(volume, flat))


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
