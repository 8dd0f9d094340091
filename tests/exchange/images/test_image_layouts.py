"""Image sets in the layout of Jacquard, read back as its readers do, with the geometry checked.

The reader here follows the published convention: GG-CNN's loader of Jacquard.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from egad.errors import UserError
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
        write_jacquard(picture, tmp_path, GRIPPER)
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


def test_missing_depths_are_zeros(sets, tmp_path):
    for picture in sets["noisy"]:
        write_jacquard(picture, tmp_path, GRIPPER)
    for _, depth, _, _ in read_jacquard(tmp_path):
        assert (depth == 0).mean() == pytest.approx(0.02, rel=0.05)


def test_images_that_do_not_fit_are_refused(sets, tmp_path):
    picture = sets["d435"][0]
    view = replace(picture.view, depth=np.ones((400, 800), np.float32))
    picture = replace(picture, view=view)
    with pytest.raises(UserError, match="square, these have 800 x 400"):
        write_jacquard(picture, tmp_path, GRIPPER)
