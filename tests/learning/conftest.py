"""Shards of synthetic images: boxes and cylinders on a table, with grasps that are known."""

import io
import json
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from PIL import Image
from typer.testing import CliRunner

from egad.cli.commands import app
from egad.detectors import Intrinsics, View, camera_above

FOCAL, FAR, SIZE = 417.0, 0.6, 300
PARTS = {"train": 0.7, "validation": 0.15, "test": 0.15}


def png(pixels):
    """A PNG file of one channel."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG")
    return buffer.getvalue()


def packed(depth):
    """A depth image as a 16-bit PNG of tenths of millimetres; 0 where there is none."""
    return png(np.nan_to_num(np.round(depth * 10_000)).astype(np.uint16))


def drawn_object(rng):
    """Half sides of a box, or a radius twice; and the height. Metres."""
    if rng.random() < 0.3:
        return "cylinder", *[rng.uniform(0.01, 0.025)] * 2, rng.uniform(0.02, 0.06)
    return "box", rng.uniform(0.008, 0.02), rng.uniform(0.03, 0.06), rng.uniform(0.02, 0.06)


def picture(kind, narrow, long, height, rng):
    """Depth of an object somewhere on the table, and grasps across it: u, v, angle, opening."""
    u, v = rng.uniform(90, 210, 2)
    turn = rng.uniform(-np.pi / 2, np.pi / 2)
    scale = FOCAL / (FAR - height)
    x, y = np.meshgrid(np.arange(SIZE) - u, v - np.arange(SIZE))
    along, aside = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
    inside = np.hypot(along, aside) < narrow * scale
    if kind == "box":
        inside = (np.abs(along) < narrow * scale) & (np.abs(aside) < long * scale)
    depth = np.where(inside, FAR - height, FAR) + rng.normal(0, 3e-4, (SIZE, SIZE))
    depth[rng.random((SIZE, SIZE)) < 0.01] = np.nan
    opening = (2 * narrow + 0.02) * scale
    if kind == "cylinder":
        angles = np.arange(6) * np.pi / 6 - np.pi / 2
        return depth, np.array([[u, v, angle, opening] for angle in angles])
    steps = np.linspace(-0.6, 0.6, 5) * long * scale
    places = np.column_stack([u - np.sin(turn) * steps, v - np.cos(turn) * steps])
    return depth, np.column_stack([places, np.full(5, turn), np.full(5, opening)])


def rows(objects, each, seed, empty=0):
    """Rows of the compact layout: so many images of each object, some without a good grasp."""
    rng = np.random.default_rng(seed)
    ends = np.cumsum(list(PARTS.values())) * objects
    for number in range(objects):
        kind, *sides = drawn_object(rng)
        split = list(PARTS)[int(np.searchsorted(ends, number, side="right"))]
        for pose in range(each):
            depth, grasps = picture(kind, *sides, rng)
            count = len(grasps)
            good = pose >= empty
            # The last two are of no use: one collides, and one would slip.
            wrong = np.array([[150, 150, 0.3, 40], [140, 160, -0.3, 40]])
            u, v, angle, opening = np.vstack([grasps, wrong]).astype(np.float32).T
            yield {
                "image": number * each + pose,
                "id": f"id{number}",
                "objects": [f"id{number}"],
                "label": f"object-{number}",
                "split": split,
                "pose": pose,
                "depth": packed(depth),
                "height": SIZE,
                "width": SIZE,
                "mask": png(np.where(depth < FAR - 0.01, np.uint8(1), np.uint8(0))),
                "focal": FOCAL,
                "center_u": 149.5,
                "center_v": 149.5,
                "u": u,
                "v": v,
                "angle": angle,
                "opening": opening,
                "depth_center": np.full(count + 2, FAR - 0.02, np.float32),
                "quality": np.array([0.004 * good] * count + [0.004, 0.001], np.float32),
                "collision_free": np.array([True] * count + [False, True]),
            }


def shards_of(folder, table, shards=2, group=16):
    """Write rows as shards with small groups of rows."""
    folder.mkdir(parents=True, exist_ok=True)
    frame = pd.DataFrame(table)
    for shard, part in enumerate(np.array_split(np.arange(len(frame)), shards)):
        path = folder / f"images-{shard}.parquet"
        rows_of_it = pa.Table.from_pandas(frame.iloc[part], preserve_index=False)
        notes = {"egad": json.dumps({"shards": shards})}
        pq.write_table(rows_of_it.replace_schema_metadata(notes), path, row_group_size=group)
    return folder


@pytest.fixture(scope="session")
def pictures():
    """Rows of 60 images of 20 objects, three each; one of these shows no good grasp."""
    return list(rows(20, 3, 0, empty=1))


@pytest.fixture(scope="session")
def write():
    """Writes rows as a folder of shards."""
    return shards_of


@pytest.fixture(scope="session")
def images(tmp_path_factory, pictures):
    """The folder of these images."""
    return shards_of(tmp_path_factory.mktemp("images"), pictures)


@pytest.fixture(scope="session")
def view(pictures):
    """The first of these images as a camera that looks straight down sees it."""
    stored = np.asarray(Image.open(io.BytesIO(pictures[0]["depth"])), dtype=np.float32)
    depth = np.where(stored > 0, stored / 10_000, np.float32(np.nan))
    return View(depth, Intrinsics(SIZE, SIZE, FOCAL, (149.5, 149.5)), camera_above(FAR))


@pytest.fixture
def check_start(tmp_path):
    """Trains with few small steps from weights and from others, and compares what comes of it."""
    files = pytest.importorskip("egad.detectors.weights")

    def check(way, start, layer):
        for name, more in (("further", ["--start", str(start)]), ("fresh", [])):
            result = CliRunner().invoke(app, [*way, *more, "--out", str(tmp_path / name)])
            assert result.exit_code == 0, result.output
        first, further, fresh = (
            files.state_in(folder / "weights.safetensors")[layer].numpy()
            for folder in (start.parent, tmp_path / "further", tmp_path / "fresh")
        )
        np.testing.assert_allclose(further, first, atol=0.0003)
        assert np.abs(fresh - first).max() > 0.01
        card = (tmp_path / "further/README.md").read_text()
        assert "| start | weights.safetensors, sha256 " in card

    return check


@pytest.fixture
def check_both_ways():
    """Compares what a command of words and one with a configuration wrote."""

    def check(folder):
        names = sorted(path.name for path in (folder / "words").iterdir())
        assert names == [
            *("README.md", "README.md.sha256", "history.parquet", "history.svg"),
            *("history.svg.sha256", "score.parquet", "weights.safetensors"),
            "weights.safetensors.sha256",
        ]
        for name in names:
            one, other = (folder / way / name for way in ("words", "config"))
            assert one.read_bytes() == other.read_bytes(), name

    return check


@pytest.fixture
def without_torch(monkeypatch):
    """PyTorch cannot be imported, as without its extra."""
    detectors = ("detectors.networks", "detectors.weights", "detectors.vgn_network")
    learning = ("learning.training", "learning.evaluation", "learning.scene_training")
    for name in (*detectors, *learning):
        monkeypatch.delitem(sys.modules, f"egad.{name}", raising=False)
        monkeypatch.delattr(f"egad.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "torch", None)
