"""Scenes of Embree: of embreex, or of libigl where embreex has no wheel, as for Linux on ARM."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Singles

HIT = [("primID", np.int64), ("tfar", np.float64), ("u", np.float32), ("v", np.float32)]
MISS = 1e37  # where a ray meets nothing


def embree_scene(vertices: Singles, faces: NDArray[np.int32]) -> Any:  # noqa: ANN401 (untyped)
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

    def __init__(self, vertices: Singles, faces: NDArray[np.int32]) -> None:
        """Prepare triangles; vertices (n, 3), faces (m, 3)."""
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
        distances = np.where(faces < 0, MISS, hits["tfar"]).astype(np.float32)
        if query == "OCCLUDED":
            return np.where(faces < 0, -1, 0)
        if not output:
            return distances
        weights = {name: hits[name] for name in ("u", "v")}
        return {"primID": faces, "tfar": distances, "Ng": self._normals[faces], **weights}
