"""Image sets in the layouts of others, read back as their readers do, with the geometry checked.

The readers here follow the published conventions (GG-CNN's loaders of Cornell and Jacquard);
GQ-CNN's tensors are opened by its own `autolab_core.TensorDataset`.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import tifffile
import trimesh
from autolab_core import TensorDataset
from PIL import Image

from egad.errors import UserError
from egad.exchange import gqcnn
from egad.exchange.cornell import write_cornell
from egad.exchange.gqcnn import write_gqcnn
from egad.exchange.jacquard import write_jacquard
from egad.grasps.room import SIDE_CLEARANCE
from egad.settings import CAMERAS, GRIPPERS, Settings
from egad.stage_settings import RenderedImages, select
from egad.vision.reach import Grasped, Hand
from egad.vision.rendering import pictures
from egad.vision.splits import Share

GRIPPER = GRIPPERS["egad_75mm"]
HAND = Hand(GRIPPER, None, 0.1)
SIDES = np.array([0.03, 0.06, 0.04])


def rendering(**changed):
    return select(Settings.model_validate(changed), RenderedImages, "egad_75mm")


@pytest.fixture(scope="module")
def sets():
    """Pictures of a block by camera; it has a grasp across each pair of its sides, and a wide one.

    The latter collides: a finger would stand in the block.
    """
    block = trimesh.creation.box(SIDES)
    axes = np.vstack([np.eye(3), [[1.0, 0, 0]]])
    widths = np.append(SIDES, 0.01)
    grasps = Grasped(np.arange(4), np.zeros((4, 3)), axes, widths, np.full(4, 0.003))

    def made(camera, **noise):
        settings = rendering(render={"camera": camera}, image_noise=noise)
        shares = [
            Share("id-1", "A1", "train", 0, 4),
            Share("id-2", "B2", "validation", 4, 2),
            Share("id-3", "C3", "test", 6, 2),
        ]
        return [p for share in shares for p in pictures(block, grasps, share, HAND, settings)]

    return {name: made(name) for name in CAMERAS} | {"noisy": made("d435", missing=0.02)}


def contacts(picture):
    """Where the contacts of each free grasp are in the image, pixels, (n, 2, 2)."""
    numbers = picture.grasps.grasp[picture.grasps.free]
    to_camera = np.linalg.inv(picture.view.pose) @ picture.matrix
    found = []
    for number in numbers:
        ends = np.outer([-0.5, 0.5], SIDES[number] * np.eye(3)[number])
        seen = ends @ to_camera[:3, :3].T + to_camera[:3, 3]
        found.append(picture.view.intrinsics.pixels(seen))
    return np.array(found).reshape(-1, 2, 2)


def check_rectangle(center, angle, opening, expected, picture, depth_center, scale=1.0):
    """A rectangle (row, column; anticlockwise) against the contacts in pixels of its image."""
    along = np.array([np.cos(angle), -np.sin(angle)])
    middle = expected.mean(axis=0)
    np.testing.assert_allclose([center[1], center[0]], middle, atol=0.02 * scale + 0.6)
    apart = expected[1] - expected[0]
    assert abs(along @ apart) == pytest.approx(np.linalg.norm(apart), rel=1e-3)
    room = 2 * SIDE_CLEARANCE * picture.view.intrinsics.focal / depth_center * scale
    assert opening == pytest.approx(np.linalg.norm(apart) + room, rel=0.05)


def read_jacquard(folder):
    """(depth, mask, [(row, column), angle, opening, jaw]) by file, as GG-CNN's loader has them."""
    for path in sorted(Path(folder).glob("*/*_grasps.txt")):
        stem = str(path).removesuffix("grasps.txt")
        with path.open() as file:
            rows = [[float(value) for value in line[:-1].split(";")] for line in file]
        grasps = [((y, x), np.radians(-theta), w, h) for x, y, theta, w, h in rows]
        depth = tifffile.imread(stem + "perfect_depth.tiff")
        yield path.name, depth, np.asarray(Image.open(stem + "mask.png")), grasps


@pytest.mark.parametrize("camera", CAMERAS)
def test_jacquard(sets, camera, tmp_path):
    known = {f"{p.image}_{p.label}_grasps.txt": p for p in sets[camera]}
    for picture in sets[camera]:
        assert write_jacquard(picture, GRIPPER, tmp_path)
    scale, seen = 1024 / 300, 0
    for name, depth, mask, grasps in read_jacquard(tmp_path):
        picture = known.pop(name)
        assert depth.shape == mask.shape == (1024, 1024)
        assert depth.dtype == np.float32
        np.testing.assert_array_equal(depth[::1023, ::1023], picture.depth[::299, ::299])
        assert (mask > 0).mean() == pytest.approx(picture.mask.mean(), rel=0.01)
        expected = (contacts(picture) + 0.5) * scale - 0.5
        free = picture.grasps.chosen(picture.grasps.free)
        assert len(grasps) == len(expected)
        for (center, angle, opening, jaw), ends, deep in zip(
            grasps, expected, free.depth_center, strict=True
        ):
            check_rectangle(center, angle, opening, ends, picture, deep, scale)
            focal = picture.view.intrinsics.focal
            assert jaw == pytest.approx(GRIPPER.finger_width * focal / deep * scale, rel=1e-4)
            seen += 1
    assert not known
    assert seen > 5


def read_cornell(folder):
    """(name, depth, rectangles of four corners (row, column)) as GG-CNN's loader has them."""
    for path in sorted(Path(folder).glob("*/pcd*cpos.txt")):
        depth = tifffile.imread(str(path).replace("cpos.txt", "d.tiff"))
        yield path, depth, corners_in(path)


def corners_in(path):
    numbers = [[float(part) for part in line.split()] for line in path.read_text().splitlines()]
    return np.array(numbers).reshape(-1, 4, 2)[..., ::-1]


@pytest.mark.parametrize("camera", CAMERAS)
def test_cornell(sets, camera, tmp_path):
    known = {f"pcd{p.image:04d}cpos.txt": p for p in sets[camera]}
    written = [write_cornell(picture, GRIPPER, tmp_path) for picture in sets[camera]]
    assert written == [bool(p.grasps.free.any()) for p in sets[camera]]
    found = list(read_cornell(tmp_path))
    assert len(found) == sum(written) > 2
    for path, depth, rectangles in found:
        picture = known[path.name]
        assert depth.shape == (480, 640)
        np.testing.assert_array_equal(depth[90:390, 170:470], picture.depth)
        steps = np.abs(np.diff(depth, axis=1))[:, [169, 469]]
        assert steps.max() < 0.001 + 0.05 * picture.mask[:, [0, -1]].any()
        expected = contacts(picture) + np.array([170, 90])
        free = picture.grasps.chosen(picture.grasps.free)
        assert len(rectangles) == len(expected)
        for points, ends, deep in zip(rectangles, expected, free.depth_center, strict=True):
            dy, dx = points[1] - points[0]
            angle = (np.arctan2(-dy, dx) + np.pi / 2) % np.pi - np.pi / 2
            opening = np.hypot(dx, dy)
            check_rectangle(points.mean(axis=0), angle, opening, ends, picture, deep)
            jaw = np.linalg.norm(points[2] - points[1])
            focal = picture.view.intrinsics.focal
            assert jaw == pytest.approx(GRIPPER.finger_width * focal / deep, abs=0.01)
            assert (points[1] - points[0]) @ (points[2] - points[1]) == pytest.approx(0, abs=0.2)
        colliding = corners_in(path.with_name(path.name.replace("cpos", "cneg")))
        assert len(colliding) == int((~picture.grasps.free).sum())


def test_gqcnn(sets, tmp_path):
    """Read by what GQ-CNN's trainer reads with."""
    chosen = sets["dexnet"]
    rows = write_gqcnn(chosen, tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    assert dataset.num_datapoints == rows == sum(len(p.grasps.u) for p in chosen)
    by_image = {p.image: p for p in chosen}
    train, validation, _ = dataset.split("object")
    assert not set(train) & set(validation)
    place = dict.fromkeys(by_image, 0)
    for index in range(rows):
        row = dataset[index]
        picture = by_image[int(row["image_labels"])]
        split = "train" if index in train else "validation" if index in validation else "test"
        assert picture.split == split
        number = place[picture.image]
        place[picture.image] += 1
        check_row(row, picture, number)
    maps = json.loads((tmp_path / "set/object_category_map.json").read_text())
    assert maps == {"A1": 0, "B2": 1, "C3": 2}


def check_row(row, picture, number):
    """A row against its grasp: the centre is in the middle, the axis along x."""
    grasps, hand = picture.grasps, row["hand_poses"]
    camera = picture.view.intrinsics
    free = bool(grasps.free[number])
    assert bool(row["collision_free"]) == free
    expected = grasps.quality[number] if free else 0
    assert row["robust_ferrari_canny"] == pytest.approx(expected, rel=1e-6)
    expected = [values[number] for values in (grasps.v, grasps.u, grasps.depth_center)]
    assert hand[:3] == pytest.approx(expected)
    assert hand[4:6] == pytest.approx(hand[:2] - np.array(camera.center)[::-1], abs=1e-3)
    assert 0 <= hand[3] < 2 * np.pi + 1e-6
    along = np.array([np.cos(hand[3]), np.sin(hand[3])])
    image, mask = row["depth_ims_tf_table"][..., 0], row["obj_masks"][..., 0]
    for column in (0, 15, 16, 31):
        x, y = (column - 15.5) * 3, 0.5 * 3
        u = grasps.u[number] + x * along[0] - y * along[1]
        v = grasps.v[number] + x * along[1] + y * along[0]
        if picture.mask[round(v), round(u)] == (mask[16, column] > 0):
            assert image[16, column] == pytest.approx(picture.depth[round(v), round(u)], abs=0.03)
    wide = SIDES[grasps.grasp[number]] if grasps.grasp[number] < 3 else None
    if free and wide is not None:
        pixels = wide * camera.focal / grasps.depth_center[number] / 3
        assert pixels - 1 <= (mask[15] > 0).sum() <= pixels + 5  # the camera sees the sides, too


@pytest.mark.parametrize("size", [1, 2, 5])
def test_files_continue_each_other(sets, tmp_path, monkeypatch, size):
    monkeypatch.setattr(gqcnn, "FILE", size)
    rows = write_gqcnn(sets["dexnet"], tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    assert (dataset.num_tensors, dataset.num_datapoints) == (-(-rows // size), rows)
    images = [p.image for p in sets["dexnet"] for _ in p.grasps.u]
    assert [int(dataset[index]["image_labels"]) for index in range(rows)] == images


def test_missing_depths_are_zeros_in_files_and_filled_in_tensors(sets, tmp_path):
    for write in (write_jacquard, write_cornell):
        for picture in sets["noisy"]:
            write(picture, GRIPPER, tmp_path / write.__name__)
    for _, depth, _, _ in read_jacquard(tmp_path / "write_jacquard"):
        assert (depth == 0).mean() == pytest.approx(0.02, rel=0.05)
    for _, depth, _ in read_cornell(tmp_path / "write_cornell"):
        assert np.isfinite(depth).all()
    write_gqcnn(sets["noisy"], tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    for index in range(dataset.num_datapoints):
        assert dataset[index]["depth_ims_tf_table"].min() > 0.4


def test_images_that_do_not_fit_are_refused(tmp_path):
    wide = {"image": [800, 400], "focal": [417, 417], "distance": [0.6, 0.6], "tilt": [0, 0]}
    settings = rendering(cameras={"wide": wide}, render={"camera": "wide"})
    block = trimesh.creation.box(SIDES)
    grasps = Grasped(np.arange(1), np.zeros((1, 3)), np.eye(3)[:1], SIDES[:1], np.ones(1))
    picture = next(pictures(block, grasps, Share("i", "l", "train", 0, 1), HAND, settings))
    with pytest.raises(UserError, match="square, these have 800 x 400"):
        write_jacquard(picture, GRIPPER, tmp_path)
    with pytest.raises(UserError, match="these 800 x 400"):
        write_cornell(picture, GRIPPER, tmp_path)


def test_tensors_need_a_grasp(tmp_path):
    settings = rendering()
    none = Grasped(np.arange(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    block, share = trimesh.creation.box(SIDES), Share("i", "l", "train", 0, 1)
    with pytest.raises(UserError, match="no grasp can be reached"):
        write_gqcnn(pictures(block, none, share, HAND, settings), tmp_path / "set")
