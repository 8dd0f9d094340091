"""What goes into GG-CNN and what is made of its answer; a stand-in takes the network's place."""

import sys
import zipfile

import numpy as np
import pytest
import trimesh

import egad.learning
from egad.detectors.ggcnn import GGCNN, MapDetector, check_ggcnn, middle
from egad.errors import UserError
from egad.learning.targets import prepare_input
from egad.perception.camera import View, camera_above
from egad.pipeline.config import GRIPPERS

HAND = GRIPPERS["egad_75mm"]
BAR = trimesh.creation.box((0.03, 0.12, 0.04))


class Stand:
    """Answers the same everywhere, but for a peak of quality at one pixel."""

    def __init__(self, row, column, angle, width):
        self.answer = np.zeros((4, 300, 300), np.float32)
        self.answer[0, row - 3 : row + 4, column - 3 : column + 4] = 1
        self.answer[1:3] = np.array([np.cos(2 * angle), np.sin(2 * angle)])[:, None, None]
        self.answer[3] = width * self.answer[0]
        self.seen = None

    def __call__(self, depth):
        self.seen = depth
        return self.answer


def answered(view, stand):
    return MapDetector(stand)(view, HAND, np.random.default_rng(0))


@pytest.mark.parametrize("size", [300, 400, 150])
def test_a_pixel_of_the_network_is_a_place_in_the_world(look, size):
    """The network's pixel lies at the same place as that of the image that it stands for."""
    view = look(BAR, size=size)
    scale = min(size, 300) / 300
    row, column = 120, 180
    found = answered(view, Stand(row, column, 0.0, 0.2))[0]
    offset = (np.array([column, row]) + 0.5 - 150) * scale / view.intrinsics.focal
    top = 0.04 if abs(offset[0] * 0.56) < 0.015 and abs(offset[1] * 0.56) < 0.06 else 0.0
    depth = 0.6 - max(top - 0.01, 0.003)
    np.testing.assert_allclose(found.center[:2], offset * depth * [1, -1], atol=1e-4)
    assert found.width == pytest.approx(
        min(0.2 * 150 * scale * depth / view.intrinsics.focal, HAND.opening), rel=1e-3
    )


@pytest.mark.parametrize("angle", [-1.2, -0.3, 0.0, 0.5, 1.5])
def test_angles_are_anticlockwise_as_seen_by_the_camera(look, angle):
    """This camera looks down with x to the right: then so they are in the world."""
    found = answered(look(BAR), Stand(150, 150, angle, 0.2))[0]
    assert found.angle == pytest.approx(angle, abs=1e-6)


def test_a_turned_camera_turns_the_grasp(look):
    view = look(BAR)
    turn = trimesh.transformations.rotation_matrix(0.4, (0, 0, 1))
    turned = View(view.depth, view.intrinsics, turn @ camera_above(0.6))
    found = answered(turned, Stand(150, 150, 0.3, 0.2))[0]
    assert found.angle == pytest.approx(0.7, abs=1e-6)


def test_fingertips_go_below_the_surface_but_not_into_the_table(look):
    on_top = answered(look(BAR), Stand(150, 150, 0.0, 0.2))[0]
    assert on_top.tip == pytest.approx(0.02, abs=1e-4)
    beside = answered(look(BAR), Stand(40, 40, 0.0, 0.2))[0]
    assert beside.tip == pytest.approx(0.003, abs=1e-4)
    assert all(grasp.infeasibility(HAND) is None for grasp in (on_top, beside))


def test_the_hand_opens_no_wider_than_it_can(look):
    found = answered(look(BAR), Stand(150, 150, 0.0, 2.0))[0]
    assert found.width == HAND.opening
    assert answered(look(BAR), Stand(150, 150, 0.0, -1.0))[0].width == 0


def test_gaps_are_filled_from_the_nearest_pixel(look):
    view = look(BAR)
    holes = view.depth.copy()
    holes[::7, ::5] = np.nan
    holes[100:104, 20:24] = np.inf
    stand = Stand(150, 150, 0.0, 0.2)
    answered(View(holes, view.intrinsics, view.pose), stand)
    assert np.isfinite(stand.seen).all()
    whole = prepare_input(middle(view.depth).depth)
    assert np.median(np.abs(stand.seen - whole)) < 1e-4


def test_what_goes_in_has_no_mean_and_is_clipped():
    depth = np.full((300, 300), 0.6)
    depth[0, 0] = 30.0
    ready = prepare_input(depth)
    assert ready.dtype == np.float32
    assert ready.max() == 1
    assert np.median(ready) == pytest.approx(0, abs=1e-3)


def test_a_blind_camera_gives_nothing(look):
    view = look(BAR)
    blind = View(np.full_like(view.depth, np.nan), view.intrinsics, view.pose)
    assert answered(blind, Stand(150, 150, 0.0, 0.2)) == []


def test_without_weights_the_message_says_where_they_are():
    with pytest.raises(UserError, match=r"needs `weights: FILE`.*dougsm/ggcnn"):
        GGCNN(None)


def test_without_pytorch_the_message_names_the_extra(monkeypatch, tmp_path):
    for name in ("networks", "weights"):
        monkeypatch.delitem(sys.modules, f"egad.learning.{name}", raising=False)
        monkeypatch.delattr(egad.learning, name, raising=False)
    monkeypatch.setitem(sys.modules, "torch", None)
    (tmp_path / "weights.pt").touch()
    with pytest.raises(UserError, match=r"egad\[vision\]"):
        GGCNN(str(tmp_path / "weights.pt"))


def test_weights_that_are_far_too_large_are_not_read(tmp_path):
    with (tmp_path / "weights.pt").open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(UserError, match="too large for weights of GG-CNN"):
        check_ggcnn(str(tmp_path / "weights.pt"))


@pytest.mark.parametrize("size", [1 << 20, 1 << 25])
def test_weights_are_not_larger_unpacked(tmp_path, size):
    path = tmp_path / "weights.pt"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data/0", bytes(size))
    assert path.stat().st_size < 100_000
    if size < 1 << 24:
        assert check_ggcnn(str(path)) == str(path)
        return
    with pytest.raises(UserError, match="too large"):
        check_ggcnn(str(path))


def test_a_damaged_zip_is_left_to_its_reader(tmp_path):
    path = tmp_path / "weights.pt"
    path.write_bytes(b"PK\x01\x02" + bytes(100) + b"PK\x05\x06" + b"\xff" * 18)
    assert check_ggcnn(str(path)) == str(path)
