"""Image sets in the layouts of others, read back as their readers do, with the geometry checked.

The readers here follow the published conventions: GG-CNN's loaders of Cornell and Jacquard.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from egad.errors import UserError
from egad.exchange.images.cornell import write_image as write_cornell
from egad.exchange.images.jacquard import write_image as write_jacquard
from egad.grippers import GRIPPERS
from egad.learning.images import CAMERAS

GRIPPER = GRIPPERS["egad_75mm"]


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
def test_jacquard(sets, contacts, check_rectangle, camera, tmp_path):
    known = {f"{p.image}_{p.label}_grasps.txt": p for p in sets[camera]}
    for picture in sets[camera]:
        assert write_jacquard(picture, tmp_path, GRIPPER)
    scale, seen = 1024 / 300, 0
    for name, depth, mask, grasps in read_jacquard(tmp_path):
        picture = known.pop(name)
        assert depth.shape == mask.shape == (1024, 1024)
        assert depth.dtype == np.float32
        np.testing.assert_array_equal(depth[::1023, ::1023], picture.depth[::299, ::299])
        assert (mask > 0).mean() == pytest.approx(picture.mask.mean(), rel=0.01)
        expected = (contacts(picture)[picture.grasps.collision_free] + 0.5) * scale - 0.5
        free = picture.grasps.chosen(picture.grasps.collision_free)
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
def test_cornell(sets, contacts, check_rectangle, camera, tmp_path):
    known = {f"pcd{p.image:04d}cpos.txt": p for p in sets[camera]}
    written = [write_cornell(picture, tmp_path, GRIPPER) for picture in sets[camera]]
    assert written == [bool(p.grasps.collision_free.any()) for p in sets[camera]]
    found = list(read_cornell(tmp_path))
    assert len(found) == sum(written) > 2
    for path, depth, rectangles in found:
        picture = known[path.name]
        assert depth.shape == (480, 640)
        np.testing.assert_array_equal(depth[90:390, 170:470], picture.depth)
        steps = np.abs(np.diff(depth, axis=1))[:, [169, 469]]
        assert steps.max() < 0.001 + 0.05 * picture.mask[:, [0, -1]].any()
        expected = contacts(picture)[picture.grasps.collision_free] + np.array([170, 90])
        free = picture.grasps.chosen(picture.grasps.collision_free)
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
        assert len(colliding) == int((~picture.grasps.collision_free).sum())


def test_missing_depths_are_zeros_for_jacquard_and_filled_for_cornell(sets, tmp_path):
    for picture in sets["noisy"]:
        write_jacquard(picture, tmp_path / "jacquard", GRIPPER)
        write_cornell(picture, tmp_path / "cornell", GRIPPER)
    for _, depth, _, _ in read_jacquard(tmp_path / "jacquard"):
        assert (depth == 0).mean() == pytest.approx(0.02, rel=0.05)
    for _, depth, _ in read_cornell(tmp_path / "cornell"):
        assert np.isfinite(depth).all()


def test_images_that_do_not_fit_are_refused(sets, tmp_path):
    picture = sets["d435"][0]
    view = replace(picture.view, depth=np.ones((400, 800), np.float32))
    picture = replace(picture, view=view)
    with pytest.raises(UserError, match="square, these have 800 x 400"):
        write_jacquard(picture, tmp_path, GRIPPER)
    with pytest.raises(UserError, match="these have 800 x 400"):
        write_cornell(picture, tmp_path, GRIPPER)
