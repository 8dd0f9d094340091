"""Scenes of spheres and boxes whose distances and grasps are known from geometry."""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pandas as pd
import trimesh

from egad.detectors import DepthCamera, Intrinsics, Observation, Tsdf, cameras_around
from egad.grasps import hand_poses

SIDE = 20  # voxels; an eighth of the work of 40
CUBE, BELOW = 0.3, 0.05
OPENING = 0.08
PARTS = (("train", 0.6), ("validation", 0.8), ("test", 1.0))


def distances(points, shapes):
    """Signed distances of points (n, 3) to shapes on a table, metres."""
    found = points[:, 2].copy()
    for kind, center, size, turn in shapes:
        local = points - center
        if kind == "sphere":
            found = np.minimum(found, np.linalg.norm(local, axis=1) - size[0])
            continue
        cosine, sine = np.cos(turn), np.sin(turn)
        x, y = cosine * local[:, 0] + sine * local[:, 1], cosine * local[:, 1] - sine * local[:, 0]
        beyond = np.abs(np.column_stack([x, y, local[:, 2]])) - size
        outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
        found = np.minimum(found, outside + np.minimum(beyond.max(axis=1), 0))
    return found


def fused(shapes):
    """The field of shapes, with what is deep inside not seen."""
    voxel = CUBE / SIDE
    corner = np.array([-CUBE / 2, -CUBE / 2, -BELOW])
    centers = corner + (np.indices((SIDE,) * 3).reshape(3, -1).T + 0.5) * voxel
    values = (distances(centers, shapes) / (4 * voxel)).reshape((SIDE,) * 3)
    weights = (values > -1).astype(np.float32)
    return Tsdf(np.clip(values, -1, 1).astype(np.float32), weights, corner, voxel, 4 * voxel)


def drawn(rng):
    """Two shapes, one of them too large for the hand; boxes are longer than wide."""
    places = rng.permutation([[-0.07, 0.0], [0.07, 0.0]]) + rng.uniform(-0.02, 0.02, (2, 2))
    shapes = []
    for place, narrow in zip(places, (0.02, 0.055), strict=True):
        kind = "sphere" if rng.random() < 0.3 else "box"
        size = np.array([narrow, max(2.2 * narrow, 0.06), 0.04]) * rng.uniform(0.9, 1.1, 3)
        height = size[0] if kind == "sphere" else size[2]
        shapes.append((kind, np.array([*place, height]), size, rng.uniform(0, np.pi)))
    return shapes


def grasps_of(shapes, count, rng):
    """Grasps from above across the narrower side; good ones are over a shape that fits the hand."""
    rows, places, axes = [], [], []
    for _ in range(count):
        _, center, size, turn = shapes[rng.integers(len(shapes))]
        shift = [*rng.normal(0, 0.02, 2), rng.uniform(-0.3, 0.3) * center[2]]
        place = center + shift
        good = bool(np.linalg.norm((place - center)[:2]) < 0.02 and 2 * size[0] < OPENING)
        rows.append({"success": good, "width": 2 * size[0] if good else np.nan, "yaws": [good]})
        places.append(place)
        axes.append([np.cos(turn), np.sin(turn), 0.0])
    down = np.tile([0.0, 0.0, -1.0], (count, 1))
    return pd.DataFrame(rows), hand_poses(np.array(places), np.array(axes), down)


class ShapeScenes:
    """Scenes with numbers; the labels can be shuffled."""

    def __init__(self, count=20, grasps=40, seed=0, shuffled=False):
        self._scenes, rows = [], []
        for number in range(count):
            rng = np.random.default_rng([seed, number])
            shapes = drawn(rng)
            table, poses = grasps_of(shapes, grasps, rng)
            if shuffled:
                table["success"] = rng.permutation(table["success"])
                table["width"] = np.where(table["success"], 0.05, np.nan)
                table["yaws"] = [[each] for each in table["success"]]
            self._scenes.append(Shown(shapes, table, poses))
            split = next(name for name, end in PARTS if number < end * count)
            rows.append(
                {
                    "scene": number,
                    "kind": "packed",
                    "split": split,
                    "objects": [f"object-{number}"],
                    "shard": number // 5,
                    "row": number % 5,
                    "grasps": len(table),
                    "positive": int(table["success"].sum()),
                }
            )
        self.index = pd.DataFrame(rows)

    def __str__(self):
        return "shapes"

    def indices(self, split):
        return np.flatnonzero(self.index["split"] == split)

    def scene(self, number):
        return self._scenes[number]


def look_at_a_box(scenes):
    """Show cameras of each scene instead of its field: they see a box. Only scene 1 has noise."""
    eye = DepthCamera(trimesh.creation.box((0.03, 0.1, 0.06)))
    cameras = cameras_around(np.array([0, 0, 0.0]), 3, 0.6, np.radians(30), 0.3)
    camera = Intrinsics(320, 240, 208.0, (159.5, 119.5))
    views = tuple(eye.render(np.eye(4), camera, pose) for pose in cameras)

    def observation(chosen=(0, 1, 2)):
        return Observation(views[chosen[0]], tuple(views[n] for n in chosen), 0.3)

    for number in range(len(scenes.index)):
        scenes.scene(number).noise = "dex" if number == 1 else "none"
        scenes.scene(number).observation = observation
    return scenes


class Shown:
    """One of them; all its cameras see everything."""

    view_count, noise = 3, "none"

    def __init__(self, shapes, grasps, poses):
        self.grasps, self.poses = grasps, poses
        self.tsdf = fused(shapes)

    def observation(self, views: Sequence[int] | None = None):
        assert views is None or 0 < len(views) <= self.view_count
        return SimpleNamespace(tsdf=self.tsdf)
