"""What goes into GG-CNN and what is made of its answer; a stand-in takes the network's place."""

import sys
import zipfile

import numpy as np
import pytest
import trimesh
from scipy import ndimage

import egad.learning
from egad.detectors import ImageNoise, View, add_sensor_noise, prepare_input
from egad.detectors.base import MIN_DEPTH
from egad.detectors.ggcnn import GGCNN, MapDetector, check_ggcnn, middle
from egad.errors import UserError
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]
BAR = trimesh.creation.box((0.03, 0.12, 0.04))
PEG = trimesh.creation.box((0.02, 0.02, 0.04))


class Stand:
    """Answers the same everywhere, but for peaks of quality at some pixels."""

    def __init__(self, angle, width, peaks):
        """Peaks: the quality at each row and column; nothing else is worth anything."""
        self.answer = np.zeros((4, 300, 300), np.float32)
        for (row, column), quality in peaks.items():
            self.answer[0, row - 3 : row + 4, column - 3 : column + 4] = quality
        self.answer[1:3] = np.array([np.cos(2 * angle), np.sin(2 * angle)])[:, None, None]
        self.answer[3] = width * self.answer[0]
        self.seen = None

    def __call__(self, depth):
        self.seen = depth
        return self.answer


def at_middle(angle=0.0, width=0.3):
    return Stand(angle, width, {(150, 150): 1.0})


def answered(view, stand):
    return MapDetector(stand)(view, HAND, np.random.default_rng(0))


@pytest.mark.parametrize(("size", "beside"), [(300, 0.042), (400, 0.031), (150, 0.042)])
def test_a_pixel_of_the_network_is_a_place_in_the_world(look, size, beside):
    """The network's pixel lies at the same place as that of the image that it stands for."""
    view = look(BAR, beside, beside, size=size)
    scale = min(size, 300) / 300
    row, column = 120, 180
    found = answered(view, Stand(0.0, 0.3, {(row, column): 1.0}))[0]
    offset = (np.array([column, row]) + 0.5 - 150) * scale / view.intrinsics.focal
    depth = 0.6 - 0.03
    np.testing.assert_allclose(found.center[:2], offset * depth * [1, -1], atol=1e-4)
    assert found.width == pytest.approx(0.3 * 150 * scale * depth / view.intrinsics.focal, rel=1e-3)


@pytest.mark.parametrize("angle", [-1.2, -0.3, 0.0, 0.5, 1.5])
def test_angles_are_anticlockwise_as_seen_by_the_camera(look, angle):
    """This camera looks down with x to the right: then so they are in the world."""
    found = answered(look(PEG), at_middle(angle))[0]
    assert found.angle == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize("sigma", [0.0, 0.1])
@pytest.mark.parametrize(
    ("height", "wall", "tip"), [(0.04, 0.0, 0.003), (0.015, 0.0, 0.003), (0.04, 0.02, 0.023)]
)
def test_fingertips_go_as_deep_as_table_and_walls_allow(look, height, wall, tip, sigma):
    view = look(trimesh.util.concatenate([bar(0.0, 0.015, height), bar(-0.042, 0.01, wall)]))
    noise = ImageNoise(disparity=sigma, holes=sigma > 0)
    stand = at_middle()
    found = answered(add_sensor_noise(view, noise, np.random.default_rng(0)), stand)[0]
    assert found.tip == pytest.approx(tip, abs=1e-4 if sigma == 0 else 0.003)
    level = height - min(height - tip, 0.02) / 2
    assert found.center[2] == pytest.approx(level, abs=1e-4 if sigma == 0 else 0.003)
    clean = prepare_input(middle(view.depth).depth)
    assert (np.abs(stand.seen - clean) > 1e-3).any() == (sigma > 0)  # the network sees the noise


def bar(x, half, height):
    """A bar along y that stands on the table at x; without height it is as thin as paper."""
    height = max(height, 1e-4)
    return trimesh.creation.box(bounds=[(x - half, -0.06, 0), (x + half, 0.06, height)])


def test_nothing_is_grasped_where_the_fingers_do_not_get_deep(look):
    assert answered(look(BAR), Stand(0.0, 0.3, {(40, 40): 1.0})) == []  # beside it
    assert answered(look(BAR), at_middle(np.pi / 2)) == []  # along it
    assert answered(look(BAR), at_middle(width=-1.0)) == []
    assert answered(look(trimesh.creation.box((0.03, 0.03, 0.007))), at_middle()) == []
    assert answered(look(trimesh.creation.box((0.03, 0.03, 0.001))), at_middle()) == []


def test_a_better_peak_that_cannot_be_reached_gives_way_to_the_next(look):
    """The wall stands where a finger would go beside the first peg."""
    pegs = [PEG.copy().apply_translation((x, 0, 0)) for x in (-0.05, 0.05)]
    wall = trimesh.creation.box((0.03, 0.06, 0.06)).apply_translation((-0.086, 0, 0.01))
    rows = {(150, 150 + round(x * 412 / 0.56)): q for x, q in ((-0.05, 1.0), (0.05, 0.8))}

    def places(*meshes):
        grasps = answered(look(trimesh.util.concatenate(meshes)), Stand(0.0, 0.3, rows))
        return [round(grasp.center[0], 2) for grasp in grasps]

    assert places(*pegs) == [-0.05, 0.05]
    assert places(*pegs, wall) == [0.05]


def every_pixel(angle):
    """A network that is as certain everywhere as it can be."""
    answer = np.ones((4, 300, 300), np.float32)
    answer[1:] = np.array([np.cos(2 * angle), np.sin(2 * angle), 0.3])[:, None, None]
    return lambda _: answer


def as_published(view, stand):
    (found,) = MapDetector(stand, "published")(view, HAND, np.random.default_rng(0))
    return found


@pytest.mark.parametrize(("height", "tip"), [(0.04, 0.03), (0.014, 0.005), (0.001, 0.005)])
def test_as_published_the_fingertips_are_10_mm_below_the_surface_and_5_mm_above_the_table(
    look, height, tip
):
    """A wall beside the object, which ours does not go into, is not looked at."""
    view = look(trimesh.util.concatenate([bar(0.0, 0.015, height), bar(-0.042, 0.01, 0.03)]))
    found = as_published(view, at_middle())
    assert found.tip == pytest.approx(tip, abs=1e-4)
    assert found.center[2] >= found.tip
    np.testing.assert_allclose(found.center[:2], 0, atol=1e-3)


def test_as_published_it_is_the_best_pixel_and_the_width_of_the_network(look):
    """At the surface of the pixel, without what is worth nothing or lies lower."""
    peaks = {(120, 180): 0.9, (150, 150): 0.5}
    view = look(BAR, 0.031, 0.031)
    found = as_published(view, Stand(0.4, 0.3, peaks))
    depth = 0.6 - BAR.extents[2]
    offset = (np.array([180, 120]) + 0.5 - 150) / view.intrinsics.focal
    np.testing.assert_allclose(found.center[:2], offset * depth * [1, -1], atol=1e-3)
    smooth = np.zeros((300, 300))
    smooth[117:124, 177:184] = 0.9
    peak = ndimage.gaussian_filter(smooth, 2.0)[120, 180]
    assert found.quality == pytest.approx(peak, rel=1e-6)
    assert found.width == pytest.approx(0.3 * peak * 150 * depth / view.intrinsics.focal, rel=1e-2)
    assert found.angle == pytest.approx(0.4, abs=1e-6)
    assert as_published(look(BAR), at_middle(width=9.0)).width == HAND.opening


def heights_under(boxes, grasp, length, width, shift):
    """The highest top of boxes under a rectangle in the axes of a grasp, point by point."""
    x, y = np.meshgrid(np.linspace(-length / 2, length / 2, 41), np.linspace(-width, width, 41) / 2)
    axis = np.array([np.cos(grasp.angle), np.sin(grasp.angle)])
    across = np.array([-axis[1], axis[0]])
    points = np.array(grasp.center[:2]) + (x[..., None] + shift) * axis + y[..., None] * across
    under = [
        top for low, (*high, top) in boxes if ((points > low[:2]) & (points < high)).all(-1).any()
    ]
    return max(under, default=0.0)


@pytest.mark.parametrize("seed", range(4))
def test_the_hand_is_beside_and_above_all_that_stands(look, seed):
    """Scenes of boxes, whose heights are known everywhere."""
    rng = np.random.default_rng(seed)
    low, size = rng.uniform(-0.08, 0.06, (6, 2)), rng.uniform(0.01, 0.04, (6, 2))
    tops = rng.uniform(0.015, 0.09, 6)
    boxes = [((*a, 0.0), (*(a + b), top)) for a, b, top in zip(low, size, tops, strict=True)]
    scene = trimesh.util.concatenate([trimesh.creation.box(bounds=box) for box in boxes])
    found = answered(look(scene), every_pixel(rng.uniform(-1.5, 1.5)))
    for grasp in found:
        off = (grasp.width + HAND.finger_thickness) / 2
        jaws = HAND.finger_thickness, HAND.finger_width
        met = max(heights_under(boxes, grasp, *jaws, side * off) for side in (-1, 1))
        palm = heights_under(boxes, grasp, *HAND.palm[:2], 0.0) - HAND.finger_length
        assert grasp.tip > max(met, palm)
        assert grasp.depth >= MIN_DEPTH / 2
        assert grasp.center[2] <= tops.max() - MIN_DEPTH / 2 + 1e-4
    assert 0 < len(found) <= 10
    assert sorted(found, key=lambda grasp: -grasp.quality) == found


def test_gaps_are_filled_with_the_farther_side(look):
    """A gap across an edge of the bar shows the table; one within the bar shows its top."""
    view = look(BAR)
    top = view.depth.min()
    row = view.depth.shape[0] // 2
    on_bar = np.flatnonzero(view.depth[row] < top + 1e-3)
    edge, inside = on_bar[0], on_bar[len(on_bar) // 2]
    holes = view.depth.copy()
    holes[row, edge - 3 : edge + 4] = np.nan
    holes[row, inside - 1 : inside + 2] = np.inf
    filled = middle(holes)
    across = filled.depth[row - filled.corner[0]]
    shown = slice(edge - 3 - filled.corner[1], edge + 4 - filled.corner[1])
    np.testing.assert_allclose(across[shown], view.depth[row, edge - 4], atol=1e-3)
    assert across[inside - filled.corner[1]] == pytest.approx(top, abs=1e-3)
    stand = at_middle()
    answered(View(holes, view.intrinsics, view.pose), stand)
    assert np.isfinite(stand.seen).all()
    whole = prepare_input(middle(view.depth).depth)
    assert np.median(np.abs(stand.seen - whole)) < 1e-4


def test_a_blind_camera_gives_nothing(look):
    view = look(BAR)
    blind = View(np.full_like(view.depth, np.nan), view.intrinsics, view.pose)
    assert answered(blind, at_middle()) == []


def test_without_weights_the_message_says_where_they_are():
    with pytest.raises(UserError, match=r"needs `weights: FILE`.*dougsm/ggcnn"):
        GGCNN(None)


def test_without_pytorch_the_message_names_the_extra(monkeypatch, tmp_path):
    for name in ("networks", "weights"):
        monkeypatch.delitem(sys.modules, f"egad.detectors.{name}", raising=False)
        monkeypatch.delattr(egad.detectors, name, raising=False)
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
