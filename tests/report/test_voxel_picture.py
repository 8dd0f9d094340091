import io

import numpy as np
import pytest
from PIL import Image

from egad.cppn.surface import surface
from egad.pipeline.config import Shape
from egad.report.render import FILL, render
from egad.report.voxel_picture import png, voxel_picture


def solid_where(condition):
    return condition(*(np.indices((25, 25, 25)) - 12))


@pytest.fixture(scope="module")
def ball():
    return solid_where(lambda x, y, z: x**2 + y**2 + z**2 <= 11**2)


def test_a_ball_is_a_disc_lit_from_the_upper_left(ball):
    grey, alpha = np.moveaxis(voxel_picture(ball, 48).astype(float), 2, 0)
    assert (alpha / 255).mean() == pytest.approx(np.pi / 4 * FILL**2, rel=0.06)
    assert grey[15, 15] > grey[15, 33] > grey[33, 33]
    assert alpha[0, 0] == alpha[-1, -1] == 0
    assert alpha[24, 24] == 255


def test_its_outline_is_that_of_the_mesh():
    bent = solid_where(
        lambda x, y, z: (abs(z) < 4) & (abs(x) < 11) & (abs(y) < 5) | (x > 6) & (abs(y) < 4)
    )
    drawn = voxel_picture(bent, 48)[..., 1] > 127
    expected = render(surface(bent, Shape()), 48)[..., 3] > 127
    assert (drawn & expected).sum() / (drawn | expected).sum() > 0.85


def test_what_lies_in_front_hides_what_lies_behind():
    """Towards the viewer: x upwards, y downwards, z upwards."""
    plate = solid_where(lambda x, y, z: (y == 0) & (abs(x) < 10) & (abs(z) < 10))
    behind = plate | solid_where(lambda x, y, z: (y > 2) & (y < 5) & (abs(x) < 2) & (abs(z) < 2))
    assert np.array_equal(voxel_picture(plate, 48), voxel_picture(behind, 48))
    before = plate | solid_where(lambda x, y, z: (y < -2) & (y > -5) & (abs(x) < 2) & (abs(z) < 2))
    assert not np.array_equal(voxel_picture(plate, 48), voxel_picture(before, 48))


def test_a_single_voxel_fills_the_picture():
    voxels = solid_where(lambda x, y, z: (x == 12) & (y == 12) & (z == 12))
    assert (voxel_picture(voxels, 16)[..., 1] > 0).mean() > 0.8


def test_a_file_holds_the_picture(ball):
    drawn = voxel_picture(ball, 20)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png(drawn)))), drawn)
