"""Messages to and from detectors in their own environment: MessagePack with arrays.

Arrays are encoded as the package msgpack-numpy does; nothing is ever unpickled.
"""

from typing import Any

import msgpack
import numpy as np

from egad.detectors.base import Answer, Grasp, poses_of
from egad.detectors.camera import Intrinsics, View
from egad.detectors.observation import Observation, PointCloud
from egad.detectors.tsdf import Tsdf
from egad.grippers import Gripper

PROTOCOL = 1
PARTS = ("view", "views", "tsdf", "cloud")  # of an observation, for detectors that ask for them
KINDS = "biuf"  # of arrays: booleans, integers, real numbers
GRASP = ("center", "angle", "width", "depth", "quality")


def packed(message: Any) -> bytes:  # noqa: ANN401 (plain values and arrays)
    """A message as bytes."""
    data: bytes = msgpack.packb(message, default=_encoded)
    return data


def unpacked(data: bytes) -> Any:  # noqa: ANN401 (plain values and arrays)
    """A message from bytes; ValueError if they are not such a message."""
    try:
        return msgpack.unpackb(data, object_hook=_decoded)
    except (msgpack.exceptions.UnpackException, TypeError, KeyError, ValueError) as error:
        raise ValueError(f"not a MessagePack message with arrays: {error}") from error


def _encoded(value: Any) -> Any:  # noqa: ANN401 (as msgpack)
    if isinstance(value, np.ndarray):
        return {
            b"nd": True,
            b"type": value.dtype.str,
            b"kind": b"",
            b"shape": value.shape,
            b"data": value.tobytes(),
        }
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be sent")


def _decoded(value: dict[Any, Any]) -> Any:  # noqa: ANN401 (as msgpack)
    if b"nd" not in value:
        return value
    kind = np.dtype(value[b"type"])
    if kind.kind not in KINDS:
        raise ValueError(f"an array of {kind}; allowed: booleans, integers, real numbers")
    data = np.frombuffer(value[b"data"], kind)
    return data.reshape(value[b"shape"]).copy() if value[b"nd"] else data[0].item()


def question(
    seen: Observation | View, observes: str, gripper: Gripper, seed: int
) -> dict[str, Any]:
    """The message that asks a detector for grasps from what it `observes`, one of `INPUTS`."""
    if isinstance(seen, View):
        parts = {"view": _view(seen)}
    elif observes == "observation":
        parts = {name: _part(getattr(seen, name)) for name in PARTS}
    else:
        parts = {observes: _part(getattr(seen, observes))}
    return {"observation": parts, "gripper": gripper.model_dump(mode="json"), "seed": seed}


def _part(part: View | PointCloud | Tsdf | tuple[View | PointCloud, ...]) -> Any:  # noqa: ANN401 (plain values)
    if isinstance(part, View):
        return _view(part)
    if isinstance(part, PointCloud):
        return part._asdict()
    if isinstance(part, Tsdf):
        return dict(part.__dict__)
    return [_part(each) for each in part]


def _view(view: View) -> dict[str, Any]:
    return {"depth": view.depth, "intrinsics": camera_matrix(view.intrinsics), "pose": view.pose}


def camera_matrix(intrinsics: Intrinsics) -> np.ndarray:
    """The matrix of a pinhole camera, (3, 3)."""
    focal, (u, v) = intrinsics.focal, intrinsics.center
    return np.array([[focal, 0.0, u], [0.0, focal, v], [0.0, 0.0, 1.0]])


def answered(message: Any) -> Answer:  # noqa: ANN401 (whatever it sent)
    """The grasps of an answer; ValueError if it is none, or says what went wrong."""
    if not isinstance(message, dict):
        raise ValueError(f"the answer must be a map, got {type(message).__name__}")
    if "error" in message:
        raise ValueError(f"it says: {message['error']}")
    try:
        if "grasps" in message:
            return _from_above(message["grasps"])
        return poses_of(tuple(message[name] for name in ("poses", "widths", "scores")))
    except KeyError as missing:
        raise ValueError(
            f"the answer has no {missing}; needed: poses, widths and scores, or grasps"
        ) from missing


def _from_above(columns: dict[str, Any]) -> list[Grasp]:
    center, *others = (np.asarray(columns[name], dtype=np.float64) for name in GRASP)
    count = len(center)
    center = center.reshape(0, 3) if count == 0 else center
    if center.shape != (count, 3) or any(each.shape != (count,) for each in others):
        raise ValueError(
            f"grasps must have center of shape (n, 3), and {', '.join(GRASP[1:])} of shape (n,)"
        )
    return [
        Grasp((x, y, z), *numbers)
        for x, y, z, *numbers in np.column_stack([center, *others]).tolist()
    ]
