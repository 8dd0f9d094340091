"""What files of grasps hold: their containers, and the grasps that the readers of formats return.

Everything here runs in the process with limits (`egad._util.limited`).
"""

import io
import json
import math
import pickle
import re
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple, cast

import numpy as np
import pandas as pd
import yaml
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad._util.extras import needed_for
from egad._util.input_limits import MAX_UNPACKED_BYTES
from egad.errors import UserError
from egad.exchange.parameters import NamedGripper
from egad.grasps import hand_poses
from egad.grippers import finger_span
from egad.io import METRES

MAX_GRASPS = 1_000_000
BLOCK = 1 << 20  # numbers that are read at once
Content = Mapping[str, Any]
_AXIS = re.compile("([+-]?)([xyz])")
# all that pickled dictionaries of arrays need; everything else could run code
_PICKLED = re.compile(
    r"numpy\.(_?core\.(multiarray|numeric)\.(_reconstruct|_frombuffer|scalar)|(ndarray|dtype))|"
    r"_codecs\.encode"
)


class FileGrasps(NamedTuple):
    """The n grasps of a file. NaN stands for what it does not say of a grasp."""

    matrices: Floats  # (n, 4, 4) as in the file, from its hand to its object or camera; metres
    # (n, 4, 4), or (1, 4, 4) if all are the same: pose of egad's hand in the hand of the file
    place: Floats
    widths: Floats  # (n,) distances between the contacts, metres
    openings: Floats  # (n,) distances between the open fingers, metres
    success: Floats  # (n,) 0 or 1
    score: Floats  # (n,) higher is better
    reference: Floats  # pose of the frame of the file in that of the mesh
    note: str  # what the user should know, if anything

    @property
    def poses(self) -> Floats:
        """(n, 4, 4) poses of egad's hand in the frame of the mesh, whatever the matrices are."""
        return self.reference @ self.matrices @ self.place


class ReadOptions(NamedTuple):
    """What the caller says about a file: see `egad.read_grasps`."""

    gripper: NamedGripper | None = None
    frame: str | None = None
    depth: float | None = None
    units: str | None = None
    reference: Floats | None = None
    object_id: str | int | None = None
    max_friction: float | None = None

    def needed(self, name: str, why: str) -> Any:  # noqa: ANN401 (of any option)
        """An option that the file leaves open; UserError that asks for it."""
        if (value := getattr(self, name)) is None:
            raise UserError(f"{why}: give `{name}`, {ASKED[name]}")
        return value

    def depth_or(self, tips: float, what: str) -> float:
        """`depth`, or that of the contacts if the fingertips are `tips` metres ahead."""
        if self.depth is not None:
            return self.depth
        why = f"{what} does not say how far ahead of its poses the contacts are"
        return tips - finger_span(self.needed("gripper", f"{why} (or give `depth`)").gripper)[1]


ASKED = {
    "gripper": "the gripper that the grasps are for",
    "frame": "the closing axis and the approach in the frame of its poses, such as 'x z' or 'y -x'",
    "depth": "how far ahead of the origin of its poses the contacts are, metres",
    "units": "m, cm or mm",
    "reference": "the (4, 4) pose of that frame in that of the mesh; if equal, the identity",
    "object_id": "which of them",
    "max_friction": "the largest friction coefficient that a grasp may need",
    "mesh": "the object in metres, and `gripper`",
}
UNITS = {name: METRES[name] for name in ("m", "cm", "mm")}


def file_grasps(
    matrices: ArrayLike,
    place: Floats,
    *,
    widths: ArrayLike = np.nan,
    openings: ArrayLike = np.nan,
    success: ArrayLike = np.nan,
    score: ArrayLike = np.nan,
    note: str = "",
) -> FileGrasps:
    """Grasps with columns (n,), or a number for all of them."""
    whole = np.asarray(matrices, dtype=np.float64)
    if whole.ndim != 3 or whole.shape[1:] != (4, 4):
        raise UserError(f"its poses have the shape {whole.shape}; allowed: (n, 4, 4)")
    columns = [np.asarray(each, np.float64) for each in (widths, openings, success, score)]
    if wrong := [each.shape for each in columns if each.ndim and each.shape != whole.shape[:1]]:
        raise UserError(f"it has {len(whole)} poses, but {wrong[0]} widths, labels or scores")
    numbers = (np.broadcast_to(each, len(whole)) for each in columns)
    return FileGrasps._make([whole, place, *numbers, np.eye(4), note])


def hand_in_frame(frame: str, depth: ArrayLike) -> Floats:
    """Poses (k, 4, 4) of egad's hand in a frame with this closing axis and approach (`"x z"`).

    The contacts are `depth`, (k,) or a number, metres, ahead of its origin along the approach.
    """
    found = [_AXIS.fullmatch(each) for each in frame.split()]
    if len(found) != 2 or not (found[0] and found[1]) or found[0][2] == found[1][2]:
        raise UserError(f"frame {frame!r} is not known; allowed: two different axes, as in 'y -x'")
    axes = [np.eye(3)["xyz".index(each[2])] * (-1 if each[1] else 1) for each in found if each]
    depths = np.atleast_1d(np.asarray(depth, np.float64))[:, None]
    closing, approach = (np.broadcast_to(axis, (len(depths), 3)) for axis in axes)
    return hand_poses(depths * approach, closing, approach)


def quaternion_poses(points: Floats, quaternions: Floats) -> Floats:
    """Poses (n, 4, 4) of points (n, 3) and quaternions (n, 4), x, y, z, w."""
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(np.reshape(quaternions, (-1, 4))).as_matrix()
    poses[:, :3, 3] = points
    return poses


def one_object(ids: Sequence[str], options: ReadOptions, what: str) -> str:
    """The object of a file that is asked for, or the only one; UserError that lists them."""
    known = sorted(set(ids))
    listed = ", ".join(known[:10]) + (", ..." if len(known) > 10 else "")
    if options.object_id is None and len(known) == 1:
        return known[0]
    chosen = str(options.needed("object_id", f"it has grasps of several {what} ({listed})"))
    if chosen not in known:
        raise UserError(f"it has no grasps of {chosen!r}, `object_id`; known: {listed}")
    return chosen


def _hdf5(path: Path) -> Content:
    with needed_for("HDF5"):
        import h5py  # noqa: PLC0415 (an extra)
    found: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:  # noqa: ANN401 (untyped)
        if isinstance(item, h5py.Dataset):
            if item.nbytes > MAX_UNPACKED_BYTES:
                raise UserError(f"its {name} has more than {MAX_UNPACKED_BYTES >> 20} MiB")
            found[name] = item[()]

    with h5py.File(path, "r") as file:
        if "datasets" in file:
            return {"path": path, "dexnet": _dexnet(file["datasets"])}
        file.visititems(visit)
    return found


def _dexnet(datasets: Any) -> dict[str, str]:  # noqa: ANN401 (untyped)
    """The groups of a Dex-Net database with grasps, by object and gripper, and by the dataset."""
    return {
        (f"{dataset}/" if len(datasets) > 1 else "") + f"{name}/{hand}": grasps.name
        for dataset, content in datasets.items()
        for name, item in content["objects"].items()
        for hand, grasps in item.get("grasps", {}).items()
        if len(grasps)
    }


def mapping(value: Any, what: str = "it") -> Content:  # noqa: ANN401 (whatever it holds)
    """Names with values that a file, or a part of it, holds; UserError if it is something else."""
    if not isinstance(value, dict):
        raise UserError(f"{what} holds a {type(value).__name__} in place of names with values")
    return cast("Content", value)


def _yaml(path: Path) -> Content:
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return mapping(yaml.load(path.read_bytes(), loader))  # noqa: S506 (both are safe)


def _csv(path: Path) -> Content:
    table = pd.read_csv(path, skipinitialspace=True)
    return {str(name): table[name].to_numpy() for name in table}


def _npy(path: Path) -> Content:
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    return {"poses" if array.ndim == 3 else "rows": array}


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401 (as in pickle)
        if not _PICKLED.fullmatch(f"{module}.{name}"):
            raise UserError(f"it has pickled code ({module}.{name}), which is not run")
        return super().find_class(module, name)


class NpzFile(Mapping[str, Any]):
    """An NPZ file, whose arrays are read when they are asked for.

    Dictionaries that NumPy pickled are read without running code.
    """

    def __init__(self, path: Path) -> None:
        """Read the names of the arrays."""
        self._zip = zipfile.ZipFile(path)
        self._sizes = {i.filename.removesuffix(".npy"): i.file_size for i in self._zip.infolist()}
        self._read: dict[str, Any] = {}

    def __iter__(self) -> Iterator[str]:
        return iter(self._sizes)

    def __len__(self) -> int:
        return len(self._sizes)

    def __contains__(self, name: object) -> bool:
        return name in self._sizes

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401 (whatever it holds)
        size = self._sizes[name]
        if name not in self._read:
            if size + sum(map(self._sizes.__getitem__, self._read)) > MAX_UNPACKED_BYTES:
                raise UserError(f"it unpacks to more than {MAX_UNPACKED_BYTES >> 20} MiB")
            with self._zip.open(f"{name}.npy") as stream:
                data = io.BytesIO(stream.read())
            if _header(data)[2].hasobject:
                value = _Unpickler(data, encoding="latin1").load()
                self._read[name] = value[()] if value.ndim == 0 else value
            else:
                data.seek(0)
                self._read[name] = np.load(data, allow_pickle=False)
        return self._read[name]

    def blocks(
        self, name: str, shape: tuple[int, ...], width: int = 1
    ) -> Iterator[tuple[int, NDArray[Any]]]:
        """An array of this shape in blocks (n, width), each with the number of its first row."""
        with self._zip.open(f"{name}.npy") as stream:
            known, by_columns, kind = _header(stream)
            if known != shape or by_columns or kind.hasobject:
                raise UserError(f"its {name} has the shape {known}; allowed: {shape}, row by row")
            rows = math.prod(shape) // width
            for first in range(0, rows, BLOCK):
                count = min(BLOCK, rows - first) * width
                block = np.frombuffer(stream.read(count * kind.itemsize), kind, count)
                yield first, block.reshape(-1, width)


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether it is stored column by column, and type of an array; reads up to its data."""
    new = np.lib.format.read_magic(stream) > (1, 0)
    read = np.lib.format.read_array_header_2_0 if new else np.lib.format.read_array_header_1_0
    header: tuple[tuple[int, ...], bool, np.dtype[Any]] = read(stream)
    return header


LOADERS: dict[str, Callable[[Path], Content]] = {
    ".h5": _hdf5,
    ".hdf5": _hdf5,
    ".json": lambda path: mapping(json.loads(path.read_bytes())),
    ".yaml": _yaml,
    ".yml": _yaml,
    ".csv": _csv,
    ".npy": _npy,
    ".npz": NpzFile,
    **dict.fromkeys((".usd", ".usda", ".usdc"), lambda path: {"usd": path}),
}
