"""Contact-GraspNet (Sundermeyer et al. 2021) in egad's benchmark: needs PyTorch, but not egad.

In a folder with this file and `detector_program.py`:

    python3.11 -m venv contact_env
    contact_env/bin/pip install "numpy<2" torch==2.13.0 torch-geometric==2.4.0 scipy msgpack \
        pyyaml trimesh tqdm importlib_resources
    contact_env/bin/pip install --no-deps cgn-pytorch==0.4.3
    egad benchmark contact_graspnet --command "contact_env/bin/python contact_graspnet.py"

This is the PyTorch version, whose package has the weights. Unlike the original, which takes points
in the frame of the camera, it was trained with points in the world, minus their mean, with the
table. So it gets the point cloud, and points of the table around it, at height 0. Its poses are of
the base of the Panda's hand: x is the closing axis, z the approach, the fingertips are 112 mm
ahead. The hand opens fully. A score is at least 0.23, as with the authors' robot.
"""

import contextlib
import importlib.resources
import sys
import types
from typing import Any

import numpy as np
from detector_program import main
from scipy.spatial import KDTree

FINGERTIPS = 0.1122  # metres from the base of the hand
LEAST = 0.23  # score; the authors executed no grasp below
GRID, SPACING = 0.005, 0.007  # metres between points of the objects, of the table
TABLE = 0.25  # metres, half a side of the square of table
CENTERS = 1024  # points at which it predicts a grasp
MARGIN = 0.01  # metres around the points of objects without points of the table

Array = np.ndarray


def scene(points: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points of the objects and of the table around them, in random order; which are of objects."""
    cells = np.floor(points / GRID).astype(int)
    points = points[np.unique(cells, axis=0, return_index=True)[1]]
    line = np.arange(-TABLE, TABLE, SPACING)
    table = np.stack([*np.meshgrid(line, line), np.zeros((len(line), len(line)))], axis=2)
    table = table.reshape(-1, 3)
    hidden = KDTree(points[:, :2]).query(table[:, :2], distance_upper_bound=MARGIN)[0] < MARGIN
    whole = np.concatenate([points, table[~hidden]])
    order = rng.permutation(len(whole))
    return whole[order], order < len(points)


def in_egad(poses: Array, finger_width: float) -> Array:
    """Poses of the base of the hand, (n, 4, 4), in egad's frame: its origin is between the pads."""
    frame = np.eye(4)
    frame[2, 3] = FINGERTIPS - finger_width / 2
    return poses @ frame


def replace_torch_cluster() -> None:
    """Functions for torch-geometric from torch-cluster, which would have to be compiled.

    All points are of one cloud. As there on a GPU, the first neighbors in a radius are taken.
    """
    import torch  # noqa: PLC0415 (it may be missing)

    def fps(points: Any, _batch: Any, ratio: float, *_: Any) -> Any:  # noqa: ANN401
        """Indices of points that are far apart."""
        chosen = torch.zeros(round(ratio * len(points)), dtype=torch.long)
        distance = torch.full((len(points),), torch.inf)
        for number in range(1, len(chosen)):
            away = (points - points[chosen[number - 1]]).square().sum(dim=1)
            distance = torch.minimum(distance, away)
            chosen[number] = distance.argmax()
        return chosen

    def radius(x: Any, y: Any, r: float, _x: Any, _y: Any, most: int, *_: Any) -> Any:  # noqa: ANN401
        """Pairs of a row of y and a row of x that are close."""
        near = torch.cdist(y, x) <= r
        near &= near.cumsum(dim=1, dtype=torch.int32) <= most
        return near.nonzero().T

    def knn(x: Any, y: Any, k: int, *_: Any) -> Any:  # noqa: ANN401
        """Pairs of a row of y and one of the nearest rows of x."""
        near = torch.cdist(y, x).topk(k, largest=False)[1]
        return torch.stack([torch.arange(len(y))[:, None].expand_as(near), near]).flatten(1)

    module: Any = types.ModuleType("torch_cluster")
    module.fps, module.radius, module.knn = fps, radius, knn
    sys.modules["torch_cluster"] = module


class ContactGraspNet:
    """The network with the weights of the package."""

    def __init__(self) -> None:
        replace_torch_cluster()
        for name in ("meshcat", "meshcat.geometry"):  # only for pictures
            sys.modules[name] = types.ModuleType(name)
        import torch  # noqa: PLC0415
        from cgn_pytorch.contact_graspnet import CGN  # noqa: PLC0415
        from cgn_pytorch.util.config_utils import load_config  # noqa: PLC0415

        torch.set_num_threads(1)  # egad runs several programs at once
        with contextlib.redirect_stdout(sys.stderr):  # egad reads the standard output
            self._torch, self._network = torch, CGN(load_config(), torch.device("cpu"))
        path = importlib.resources.files("cgn_pytorch") / "checkpoints/current.pth"
        state = torch.load(str(path), map_location="cpu", weights_only=False)["state_dict"]
        self._network.load_state_dict(state)
        self._network.eval()

    def __call__(
        self, observation: dict[str, Any], gripper: dict[str, Any], rng: np.random.Generator
    ) -> tuple[Array, Array, Array]:
        """Poses, widths and scores."""
        points = observation["cloud"]["points"]
        if len(points) == 0:
            return np.zeros((0, 4, 4)), np.zeros(0), np.zeros(0)
        points, of_objects = scene(points, rng)
        middle = points.mean(axis=0)
        torch = self._torch
        cloud = torch.from_numpy(points - middle).float()
        batch = torch.zeros(len(cloud), dtype=torch.long)
        centers = sys.modules["torch_cluster"].fps(cloud, batch, min(1, CENTERS / len(cloud)))
        with torch.no_grad():
            # Predicted widths reach 80 mm.
            _, poses, scores, *_ = self._network(
                cloud[:, 3:], cloud, batch, centers, gripper_width=0.16
            )
        scores = torch.sigmoid(scores[0]).numpy().astype(np.float64)
        scores[~of_objects[centers.numpy()]] = 0.0
        best = np.argsort(-scores, kind="stable")[:50]
        best = best[scores[best] >= LEAST]
        poses = poses[0].numpy().astype(np.float64)[best]
        poses[:, :3, 3] += middle
        poses = in_egad(poses, gripper["finger_width"])
        return poses, np.full(len(best), gripper["opening"]), scores[best]


if __name__ == "__main__":
    try:
        network = ContactGraspNet()
    except ImportError as error:
        sys.exit(
            f"contact_graspnet: the environment lacks a package ({error}); contact_graspnet.py "
            "says how to set it up"
        )
    main(network, "cloud")
