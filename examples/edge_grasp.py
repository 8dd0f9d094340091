"""VN-EdgeGrasp (Huang et al. 2023) in egad's benchmark: needs PyTorch, but not egad.

In a folder with this file and `detector_program.py`:

    git clone https://github.com/HaojHuang/Edge-Grasp-Network
    python3.11 -m venv edge_env
    edge_env/bin/pip install torch==2.13.0 numpy scipy scikit-learn msgpack
    egad benchmark edge_grasp --command "edge_env/bin/python edge_grasp.py" --protocol edgegrasp

The repository has the weights, too. It takes the point cloud in the world, at least 5 mm above the
table. As in its `test_clutter_grasp.py`, outliers are removed, normals estimated, the points
reduced to a grid of 4.5 mm, and 32 of them, far apart, are the approach points. A pair of an
approach point and a contact, at most 38 mm away, is a grasp: the hand closes along the normal of
the contact, fully open, with its fingertips 7 mm deeper than the contact. The repository's frame of
the hand closes along y, and its origin is 72 mm before the fingertips.
"""

import contextlib
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
from detector_program import main
from scipy.spatial import KDTree

REPOSITORY = Path(__file__).with_name("Edge-Grasp-Network")
SIDE, LOWEST = 0.26, 0.005  # metres: of the square on the table, and above it
GRID, NEIGHBORS, RADIUS = 0.0045, 30, 0.03  # metres, points, metres
APPROACH_POINTS, BALL = 32, 0.05  # and metres
MAX_GRASPS = 1500
FINGERTIPS, CONTACTS = 0.0722, 0.065  # metres from the origin of the repository's frame
# Corners of the hand in that frame, which must be 4 mm above the table
HAND = [[0, 0, -0.02], [0.005, 0.09, 0.078], [0.005, -0.09, 0.078]]
HAND += [[x, y, 0.015] for x in (-0.012, 0.012) for y in (-0.09, 0.09)]

Array = np.ndarray


def prepare(points: Array, outward: Array) -> tuple[Array, Array]:
    """Points on a grid, without outliers, and their normals, estimated from the points."""
    inside = (np.abs(points[:, :2]) < SIDE / 2).all(axis=1) & (points[:, 2] > LOWEST)
    points, outward = points[inside], outward[inside]
    if len(points) <= NEIGHBORS:
        return points[:0], outward[:0]
    distance = KDTree(points).query(points, NEIGHBORS)[0].mean(axis=1)
    keep = distance < distance.mean() + distance.std()
    points, outward = points[keep], outward[keep]
    tree = KDTree(points)
    keep = tree.query_ball_point(points, RADIUS, return_length=True) > NEIGHBORS
    around = points[tree.query(points, min(NEIGHBORS, len(points)))[1]]
    around = around - around.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]
    normals *= np.where(np.einsum("ni,ni->n", normals, outward) < 0, -1.0, 1.0)[:, None]
    return on_grid(points[keep], normals[keep])


def on_grid(points: Array, normals: Array) -> tuple[Array, Array]:
    """The mean of the points in each cell of the grid, and of their normals."""
    if len(points) == 0:
        return points, normals
    cells = np.floor((points - points.min(axis=0)) / GRID + 0.5).astype(int)
    _, cell, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), 6))
    np.add.at(sums, cell.ravel(), np.hstack([points, normals]))
    return sums[:, :3] / count[:, None], unit(sums[:, 3:])


def unit(vectors: Array) -> Array:
    """Vectors of length 1."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def farthest(points: Array, count: int, first: int) -> Array:
    """Indices of points that are far apart."""
    chosen, distance = [first], np.full(len(points), np.inf)
    while len(chosen) < min(count, len(points)):
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(distance.argmax()))
    return np.array(chosen)


def hand_frames(points: Array, normals: Array, upward: Array, depth: Array) -> Array:
    """Poses of the repository's hand, (n, 4, 4): it closes along y, and z is the approach.

    Args:
        points: (n, 3) approach points.
        normals: (n, 3) unit normals at the contacts.
        upward: (n, 3) unit vectors against the approach, at right angles to the normals.
        depth: (n,) how much deeper than the approach points the contacts are, metres.
    """
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    poses[:, :3, :3] = np.stack([np.cross(normals, -upward), normals, -upward], axis=2)
    poses[:, :3, 3] = points + (CONTACTS - depth)[:, None] * upward
    return poses


def in_egad(poses: Array, finger_width: float) -> Array:
    """The same hands in egad's frame, which closes along x: its origin is between the pads."""
    frame = np.eye(4)
    frame[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    frame[2, 3] = FINGERTIPS - finger_width / 2
    return poses @ frame


class EdgeGrasp:
    """The network with its published weights."""

    def __init__(self) -> None:
        import torch  # noqa: PLC0415 (it may be missing)

        def knn_graph(points: Any, k: int, batch: Any, loop: bool) -> Any:  # noqa: ANN401
            assert loop  # noqa: S101
            edges = []
            for number in range(int(batch[-1]) + 1):
                rows = torch.nonzero(batch == number).ravel()
                distance = torch.cdist(points[rows], points[rows])
                near = distance.topk(min(k, len(rows)), largest=False)[1]
                edges.append(torch.stack([rows[near], rows[:, None].expand_as(near)]).flatten(1))
            return torch.cat(edges, dim=1)

        def scatter_max(values: Any, index: Any, dim: int, out: Any) -> tuple[Any, Any]:  # noqa: ANN401
            assert dim == 0  # noqa: S101
            spread = index[:, None, None].expand_as(values)
            most = out.scatter_reduce(0, spread, values, "amax")
            rows = torch.arange(len(values))[:, None, None].expand_as(values)
            rows = torch.where(values == most[index], rows, len(values))
            none = torch.full(out.shape, len(values))
            return most, none.scatter_reduce(0, spread, rows, "amin")

        # The two packages would have to be compiled; of them, these two functions are used.
        for name, function in (("torch_geometric.nn", knn_graph), ("torch_scatter", scatter_max)):
            module: Any = types.ModuleType(name)
            module.knn_interpolate = module.global_max_pool = module.scatter = None
            setattr(module, function.__name__, function)
            sys.modules[name] = module
        sys.modules["torch_geometric"] = types.ModuleType("torch_geometric")
        if not REPOSITORY.is_dir():
            sys.exit(f"edge_grasp: {REPOSITORY} is missing; edge_grasp.py says how to get it")
        sys.path.insert(0, str(REPOSITORY / "models"))
        from vn_edge_grasp_network import EdgeGrasp as Network  # noqa: PLC0415

        torch.set_num_threads(1)  # egad runs several programs at once
        with contextlib.redirect_stdout(sys.stderr):  # egad reads the standard output
            self._torch, self._network = torch, Network(torch.device("cpu"))
        folder = REPOSITORY / "vn_edge_pretrained_para/checkpoints"
        parts = ("local_emd_model", "global_emd_model", "classifier_model", "std")
        self._network.load(*(str(folder / f"{part}-ckpt-105.pt") for part in parts))

    def __call__(
        self, observation: dict[str, Any], gripper: dict[str, Any], rng: np.random.Generator
    ) -> tuple[Array, Array, Array]:
        """Poses, widths and scores."""
        cloud = observation["cloud"]
        points, normals = prepare(cloud["points"], cloud["normals"])
        if len(points) < 100:
            return np.zeros((0, 4, 4)), np.zeros(0), np.zeros(0)
        first = int(rng.integers(len(points)))
        sample = np.unique(farthest(points, APPROACH_POINTS, first))
        balls = KDTree(points).query_ball_point(points[sample], BALL)
        ball = np.repeat(np.arange(len(sample)), [len(each) for each in balls])
        contact = np.concatenate(balls).astype(int)
        offset = points[contact] - points[sample[ball]]
        normal, distance = normals[contact], np.linalg.norm(offset, axis=1)
        inward = offset - np.einsum("ni,ni->n", offset, normal)[:, None] * normal
        depth, upward = np.linalg.norm(inward, axis=1), unit(-inward)
        good = (upward[:, 2] > -0.1) & (distance > 0.003) & (distance < 0.038)
        chosen = np.flatnonzero(good & (depth > 1e-9) & (depth < 0.04))
        poses = hand_frames(points[sample[ball]], normal, upward, depth)
        corners = poses[chosen, 2, :3] @ np.transpose(HAND) + poses[chosen, 2, 3:]
        chosen = chosen[(corners > 0.004).all(axis=1)]
        chosen = np.sort(rng.permutation(chosen)[:MAX_GRASPS])
        if len(chosen) == 0:
            return np.zeros((0, 4, 4)), np.zeros(0), np.zeros(0)
        scores = self._scores(points, normals, sample, ball, contact, chosen, upward, depth)
        best = np.argsort(-scores, kind="stable")[:50]
        found = in_egad(poses[chosen[best]], gripper["finger_width"])
        return found, np.full(len(best), gripper["opening"]), scores[best]

    def _scores(
        self,
        points: Array,
        normals: Array,
        sample: Array,
        ball: Array,
        contact: Array,
        chosen: Array,
        upward: Array,
        depth: Array,
    ) -> Array:
        """The success that the network predicts for some pairs of approach point and contact.

        One approach point after the other: the result is the same, in half the time.
        """
        torch, scores, start = self._torch, np.zeros(len(chosen)), 0
        for number, size in enumerate(np.bincount(ball, minlength=len(sample)).tolist()):
            rows = slice(start, start + size)
            mine = (chosen >= start) & (chosen < start + size)
            start += size
            if not mine.any():
                continue
            arrays = {
                "pos": points,
                "normals": normals,
                "sample": sample[number : number + 1],
                "ball_batch": np.zeros(size, dtype=int),
                "ball_edges": np.column_stack([np.full(size, sample[number]), contact[rows]]),
                "reindexes": chosen[mine] - rows.start,
                "approaches": upward[chosen[mine]],
                "depth_proj": depth[chosen[mine]],
            }
            tensors = {name: torch.from_numpy(values) for name, values in arrays.items()}
            singles = {k: v.float() if v.is_floating_point() else v for k, v in tensors.items()}
            with torch.no_grad():
                scores[mine] = self._network.act(types.SimpleNamespace(**singles))[0].numpy()
        return 1 / (1 + np.exp(-scores))


if __name__ == "__main__":
    try:
        network = EdgeGrasp()
    except ImportError as error:
        sys.exit(
            f"edge_grasp: the environment lacks a package ({error}); edge_grasp.py says how to "
            "set it up"
        )
    main(network, "cloud")
