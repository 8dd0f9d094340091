"""An image as a row of a table: depths and mask as PNG files, poses as numbers, grasps as lists."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.tables.columns import POSE_PARTS
from egad.tables.images import LISTS
from egad.vision.camera import Intrinsics, View
from egad.vision.png import coded, depth_of, pixels, png
from egad.vision.projection import ImageGrasps
from egad.vision.rendering import Picture

Floats = NDArray[np.float64]


def encoded(picture: Picture) -> dict[str, Any]:
    """The row of `tables.images.IMAGES` of a picture."""
    height, width = picture.depth.shape
    intrinsics = picture.view.intrinsics
    grasps = picture.grasps
    return {
        **{name: getattr(picture, name) for name in ("image", "id", "label", "split", "pose")},
        "depth": png(coded(picture.depth)),
        "mask": png(np.where(picture.mask, np.uint8(255), np.uint8(0))),
        "height": height,
        "width": width,
        "focal": intrinsics.focal,
        "center_u": intrinsics.center[0],
        "center_v": intrinsics.center[1],
        **_pose_columns("camera", picture.view.pose),
        **_pose_columns("object", picture.matrix),
        **{name: getattr(grasps, name) for name in LISTS},
    }


def decoded(row: Mapping[str, Any]) -> Picture:
    """The picture of a row of `tables.images.IMAGES`.

    Raises:
        TableError: A PNG file of it is damaged, or of another size.
    """
    center = (float(row["center_u"]), float(row["center_v"]))
    intrinsics = Intrinsics(row["width"], row["height"], float(row["focal"]), center)
    return Picture(
        image=int(row["image"]),
        id=row["id"],
        label=row["label"],
        split=row["split"],
        pose=int(row["pose"]),
        view=View(depth_of(row), intrinsics, _pose_matrix("camera", row)),
        mask=pixels(row, "mask", "L") > 0,
        matrix=_pose_matrix("object", row),
        grasps=ImageGrasps(*(np.asarray(row[name]) for name in LISTS)),
    )


def pose_values(matrix: Floats) -> list[float]:
    """Position and quaternion (x, y, z, w) of a transform (4, 4)."""
    quaternion = Rotation.from_matrix(matrix[:3, :3]).as_quat(canonical=True)
    return [*matrix[:3, 3].tolist(), *quaternion.tolist()]


def _pose_columns(name: str, matrix: Floats) -> dict[str, float]:
    pairs = zip(POSE_PARTS, pose_values(matrix), strict=True)
    return {f"{name}_{part}": value for part, value in pairs}


def _pose_matrix(name: str, row: Mapping[str, Any]) -> Floats:
    values = [float(row[f"{name}_{part}"]) for part in POSE_PARTS]
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(values[3:]).as_matrix()
    matrix[:3, 3] = values[:3]
    return matrix
