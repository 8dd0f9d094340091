"""graspgen: grasps from a server of GraspGen (Murali et al. 2025), asked over ZeroMQ."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from egad._util.arrays import Floats
from egad._util.extras import needed_for
from egad.detectors.base import WHERE, GraspPoses, poses_of
from egad.detectors.messages import packed, unpacked
from egad.detectors.observation import PointCloud
from egad.errors import UserError
from egad.grippers import Gripper

GREETING_TIME = 60_000  # milliseconds; it may still be busy with an earlier question
GRASPS = 200  # of each object
MIN_POINTS = 21  # of an object: the server compares each point with its 20 nearest
# From the base of its grippers to where their pads touch, along the approach, metres; from the
# gripper descriptions of GraspGen.
DEPTHS = {"franka_panda": 0.1053, "robotiq_2f_140": 0.195, "robotiq_2f_85": 0.1303}


class GraspGen:
    """A server of GraspGen, trained with single objects and so asked about one at a time."""

    def __init__(self, address: str) -> None:
        """Connect to a server, such as tcp://localhost:5556; UserError if it cannot be used."""
        with needed_for("graspgen"):
            import zmq  # noqa: PLC0415 (an extra)
        self._socket: Any = zmq.Context.instance().socket(zmq.REQ)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.RCVTIMEO, GREETING_TIME)
        try:
            self._socket.connect(address)
            name = self._ask({"action": "metadata"}).get("gripper_name")
        except (zmq.ZMQError, ValueError) as error:
            raise UserError(f"{WHERE}: no GraspGen server at {address}: {error}") from error
        if name not in DEPTHS:
            raise UserError(
                f"{WHERE}: the GraspGen server has the gripper {name}; known: {', '.join(DEPTHS)}"
            )
        self._depth = DEPTHS[name]
        self._socket.setsockopt(zmq.RCVTIMEO, -1)  # from now on, the caller has a limit

    def __call__(
        self, object_clouds: Sequence[PointCloud], gripper: Gripper, _rng: np.random.Generator
    ) -> GraspPoses:
        """Grasps of all objects with 21 points or more; the hand opens as wide as it can."""
        clouds = [points for points, _ in object_clouds if len(points) >= MIN_POINTS]
        found = [self._grasps(points, gripper) for points in clouds]
        return GraspPoses(*map(np.concatenate, zip(poses_of(([], [], [])), *found, strict=True)))

    def _grasps(self, points: Floats, gripper: Gripper) -> GraspPoses:
        """Grasps of the object to which points (n, 3) belong."""
        asked = {"action": "infer", "point_cloud": points.astype(np.float32), "num_grasps": GRASPS}
        answer = self._ask(asked | {"topk_num_grasps": GRASPS})
        poses = np.asarray(answer["grasps"], dtype=np.float64)
        scores = np.asarray(answer["confidences"], dtype=np.float64)
        grasps = poses_of((poses, np.full(len(poses), gripper.opening), scores))
        grasps.poses[:, :3, 3] += self._depth * grasps.poses[:, :3, 2]
        return grasps

    def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """Send a request; the answer, or ValueError if it is no message or reports an error."""
        self._socket.send(packed(request))
        answer = unpacked(self._socket.recv())
        if not isinstance(answer, dict) or "error" in answer:
            raise ValueError(f"the GraspGen server says: {answer}")
        return answer
