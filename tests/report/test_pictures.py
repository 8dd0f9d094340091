import io

import numpy as np
import pytest
import trimesh
from PIL import Image

from egad.errors import RejectedError
from egad.evolution import Shape
from egad.evolution.growth import surface
from egad.report.pictures import CAMERA, FILL, png_bytes, render, voxel_picture, voxel_png


def decoded(content: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGBA"))


@pytest.fixture(scope="module")
def ball() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=4)


def test_a_ball_covers_the_area_of_its_disc(ball):
    alpha = render(ball, 96)[..., 3] / 255
    assert alpha.mean() == pytest.approx(np.pi / 4 * FILL**2, rel=0.01)
    assert alpha[48, 48] == 1
    assert alpha[0, 0] == alpha[-1, -1] == 0


def test_light_comes_from_the_upper_left(ball):
    tone = render(ball, 96)[..., 0].astype(int)
    assert tone[30, 30] > tone[30, 66] > tone[66, 66]


def test_size_and_place_do_not_matter(ball):
    bent = ball.copy()
    bent.vertices[:, 0] *= 0.6
    moved = bent.copy()
    moved.apply_scale(0.001)
    moved.apply_translation([0.3, -0.2, 5])
    difference = render(bent).astype(int) - render(moved).astype(int)
    assert np.abs(difference).mean() < 0.5


def test_winding_does_not_matter():
    knot = trimesh.creation.torus(1, 0.4)
    inverted = trimesh.Trimesh(knot.vertices, knot.faces[:, ::-1], process=False)
    difference = render(knot).astype(int) - render(inverted).astype(int)
    assert (np.abs(difference).max(axis=2) > 2).mean() < 0.005


def test_sharp_edges_stay_sharp():
    box = trimesh.creation.box((1, 0.8, 0.6))
    apart = trimesh.Trimesh(
        box.vertices[box.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False
    )
    assert len(box.vertices) == 8
    difference = render(box).astype(int) - render(apart).astype(int)
    assert np.abs(difference).max() <= 1


def test_a_floor_is_darker_beside_a_wall():
    floor = trimesh.creation.box((2, 2, 0.1))
    wall = trimesh.creation.box((0.2, 2, 1.5))
    wall.apply_translation([-0.9, 0, 0.7])
    scene = trimesh.util.concatenate([floor, wall])
    picture = render(scene, 96)
    seen = scene.vertices @ CAMERA.T
    center, reach = (seen.max(0) + seen.min(0)) / 2, np.ptp(seen[:, :2], axis=0).max() / 2

    def tone(x: float) -> int:
        place = (CAMERA @ [x, -0.3, 0.05] - center) / reach * FILL
        column, row = (place[:2] * [1, -1] + 1) / 2 * 96
        return int(picture[int(row), int(column), 0])

    assert tone(-0.7) < tone(-0.5) < tone(0.6)


def test_the_same_mesh_gives_the_same_bytes(ball):
    assert png_bytes(render(ball)) == png_bytes(render(ball.copy()))


def test_what_cannot_be_drawn_is_rejected(ball):
    with pytest.raises(RejectedError, match="no faces"):
        render(trimesh.Trimesh())
    broken = ball.copy()
    broken.vertices[3, 1] = np.nan
    with pytest.raises(RejectedError, match="not finite"):
        render(broken)


def test_a_flat_mesh_seen_from_its_edge_is_drawn():
    line = trimesh.Trimesh([[0, 0, 0], [0, 0, 0], [0, 0, 0]], [[0, 1, 2]], process=False)
    assert render(line, 16)[..., 3].max() == 0


@pytest.mark.parametrize("noisy", [False, True])
def test_png_keeps_the_picture(ball, noisy):
    picture = render(ball)
    if noisy:
        picture = np.random.default_rng(0).integers(0, 256, picture.shape, dtype=np.uint8)
    found = decoded(png_bytes(picture)).astype(int)
    assert np.abs(found[..., 3] - picture[..., 3]).max() <= 26
    solid = picture[..., 3] > 26
    assert np.abs(found - picture)[solid][:, :3].max() <= 4


def solid_where(condition):
    return condition(*(np.indices((25, 25, 25)) - 12))


@pytest.fixture(scope="module")
def voxel_ball():
    return solid_where(lambda x, y, z: x**2 + y**2 + z**2 <= 11**2)


def test_a_ball_of_voxels_is_a_disc_lit_from_the_upper_left(voxel_ball):
    grey, alpha = np.moveaxis(voxel_picture(voxel_ball, 48).astype(float), 2, 0)
    assert (alpha / 255).mean() == pytest.approx(np.pi / 4 * FILL**2, rel=0.06)
    assert grey[15, 15] > grey[15, 33] > grey[33, 33]
    assert alpha[0, 0] == alpha[-1, -1] == 0
    assert alpha[24, 24] == 255


def test_the_outline_of_voxels_is_that_of_the_mesh():
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


def test_a_file_holds_the_picture_of_voxels(voxel_ball):
    drawn = voxel_picture(voxel_ball, 20)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(voxel_png(drawn)))), drawn)
