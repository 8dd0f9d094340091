"""antipodal-depth finds the obvious grasps, and none where there are none."""

import numpy as np
import pytest
import trimesh

from egad.detectors import (
    DepthCamera,
    ImageNoise,
    Intrinsics,
    View,
    add_sensor_noise,
    camera_above,
    table_depth,
)
from egad.detectors.antipodal import _Edges, _edges, _pairs, _uneven, antipodal_depth
from egad.detectors.base import Grasp
from egad.detectors.camera import WHOLE
from egad.detectors.heightmap import heightmap_of
from egad.grippers import GRIPPERS, Gripper

HAND = GRIPPERS["egad_75mm"]
CAMERA = Intrinsics.spanning(300, 300, 40.0)


def seen(mesh: trimesh.Trimesh, x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> View:
    """A view of a mesh that stands on the table."""
    matrix = trimesh.transformations.rotation_matrix(turn, (0, 0, 1))
    matrix[:3, 3] = [x, y, -mesh.bounds[0, 2]]
    return DepthCamera(mesh).render(matrix, CAMERA, camera_above(0.6))


def noisy(view: View, sigma: float, seed: int = 0) -> View:
    """The view with holes, and with disparity noise of some pixels."""
    noise = ImageNoise(disparity=sigma, holes=True)
    return add_sensor_noise(view, noise, np.random.default_rng(seed))


def detect(view: View, gripper: Gripper = HAND) -> list[Grasp]:
    return antipodal_depth(view, gripper, np.random.default_rng(0))


def folded(angle: float) -> float:
    """An angle of an axis, which has no direction, in [-pi / 2, pi / 2)."""
    return (angle + np.pi / 2) % np.pi - np.pi / 2


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.0])
@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.08, -0.05)])
def test_a_bar_is_grasped_across_its_middle(turn: float, x: float, y: float) -> None:
    grasps = detect(seen(trimesh.creation.box((0.03, 0.12, 0.04)), x, y, turn))
    first = grasps[0]
    assert folded(first.angle - turn) == pytest.approx(0, abs=0.1)
    np.testing.assert_allclose(first.center[:2], [x, y], atol=0.006)
    assert 0.03 < first.width <= HAND.opening
    assert 0 < first.tip < 0.01
    assert 0.02 < first.center[2] + first.depth < 0.045
    assert first.quality > 0.8


def test_grasps_are_ranked_and_within_bounds() -> None:
    grasps = detect(seen(trimesh.creation.cylinder(0.02, 0.06)))
    qualities = [grasp.quality for grasp in grasps]
    assert 0 < len(grasps) <= 50
    assert qualities == sorted(qualities, reverse=True)
    assert all(0 <= quality <= 1 for quality in qualities)
    assert all(grasp.infeasibility(HAND) is None for grasp in grasps)


@pytest.mark.parametrize("sides", [(0.12, 0.12, 0.06), (0.12, 0.12, 0.004)])
def test_nothing_is_found_on_what_is_too_wide_or_too_flat(sides: tuple[float, ...]) -> None:
    assert detect(seen(trimesh.creation.box(sides))) == []


def test_an_empty_table_gives_nothing() -> None:
    matrix = trimesh.transformations.translation_matrix((5, 5, 0))
    empty = DepthCamera(trimesh.creation.box((0.1, 0.1, 0.1))).render(
        matrix, CAMERA, camera_above(0.6)
    )
    assert detect(empty) == []
    blind = View(np.full_like(empty.depth, np.nan), CAMERA, camera_above(0.6))
    assert detect(blind) == []


def test_gentle_slopes_are_no_edges() -> None:
    """A cone of 45 degrees slips out between pads with a friction of 0.5."""
    cone = trimesh.creation.cone(0.03, 0.03)
    steep = trimesh.creation.cone(0.03, 0.12)
    assert detect(seen(cone)) == []
    assert detect(seen(steep)) != []


@pytest.mark.parametrize("sigma", [0.0, 0.1])
def test_fingers_need_space_beside_the_object(sigma: float) -> None:
    """Between a block and walls 15 mm away, pads that open 8 mm wider and are 10 mm thick."""
    block = trimesh.creation.box((0.03, 0.03, 0.05))
    walls = [
        trimesh.creation.box((0.01, 0.2, 0.05), trimesh.transformations.translation_matrix(at))
        for at in ((-0.035, 0, 0), (0.035, 0, 0))
    ]

    def angles(mesh: trimesh.Trimesh) -> set[str]:
        found = [
            grasp
            for grasp in detect(noisy(seen(mesh), sigma))
            if np.hypot(*grasp.center[:2]) < 0.01
        ]
        return {"across" if abs(folded(grasp.angle)) < 0.5 else "along" for grasp in found}

    assert angles(block) == {"across", "along"}
    assert angles(trimesh.util.concatenate([block, *walls])) == {"along"}


def test_the_palm_stays_above_the_object() -> None:
    tower = trimesh.creation.box((0.04, 0.04, 0.15))
    assert all(grasp.tip > 0.15 - HAND.finger_length for grasp in detect(seen(tower)))


NOISE = [(0.0, 0.003), (0.1, 0.006), (0.2, 0.009)]  # pixels; metres that the axis may be off


@pytest.mark.parametrize(("sigma", "near"), NOISE)
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_with_noise_a_bar_is_held_across(turn: float, sigma: float, near: float) -> None:
    view = seen(trimesh.creation.box((0.03, 0.12, 0.04)), 0.03, -0.02, turn)
    for seed in range(5):
        first = detect(noisy(view, sigma, seed))[0]
        assert np.isfinite([*first.center, first.angle, first.width, first.depth]).all()
        assert abs(folded(first.angle - turn)) < 0.1 + 2 * sigma
        away = np.array(first.center[:2]) - (0.03, -0.02)
        assert abs(away @ (np.cos(turn), np.sin(turn))) < near
        assert 0.03 < first.width <= HAND.opening
        assert first.tip < 0.02


@pytest.mark.parametrize("sides", [(0.12, 0.12, 0.06), (0.12, 0.12, 0.004), (0.01, 0.01, 0.001)])
def test_noise_makes_no_grasps_where_there_are_none(sides: tuple[float, ...]) -> None:
    view = seen(trimesh.creation.box(sides))
    assert all(detect(noisy(view, 0.1, seed)) == [] for seed in range(5))


def test_the_same_image_gives_the_same_grasps() -> None:
    view = seen(trimesh.creation.box((0.03, 0.06, 0.04)), turn=0.3)
    other = antipodal_depth(view, HAND, np.random.default_rng(99))
    assert detect(view) == other


def rough(rng: np.random.Generator, friction: float) -> View:
    """A table seen at a slant, with noise on it that is no edge, blocks, patches and blind pixels.

    What rises from it does so by between 0.3 and 20 times the least height that may be an edge.
    """
    camera = Intrinsics.spanning(120, 100, 40.0)
    tilt = trimesh.transformations.rotation_matrix(rng.uniform(-0.3, 0.3), rng.normal(size=3))
    pose = tilt @ camera_above(0.6)
    pose[:3, 3] = [0, 0, 0.6]
    table = table_depth(camera, pose)
    least = 0.6 / camera.focal / friction / 2
    rise = rng.uniform(-0.3, 0.3, table.shape) * least
    for noise in (0.0, 2.0, 2.0):
        (top, left), (high, wide) = rng.integers(15, 60, 2), rng.integers(1, 20, 2)
        patch = rise[top : top + high, left : left + wide]
        patch += least * 20 ** rng.uniform(-0.3, 1) * rng.uniform(1 - noise, 1, patch.shape)
    depth = table - rise
    depth[rng.random(depth.shape) < 0.001] = np.nan
    return View(depth.astype(np.float32), camera, pose)


@pytest.mark.parametrize("friction", [0.3, 0.5, 1.0])
def test_what_is_looked_at_of_an_image_gives_the_edges_and_heights_of_all_of_it(
    friction: float,
) -> None:
    found = []
    for seed in range(40):
        view = rough(np.random.default_rng(seed), friction)
        np.testing.assert_allclose(view.heights(), view.points()[..., 2], atol=1e-12)
        window = _uneven(view, friction)
        part, whole = _edges(view, window, friction), _edges(view, WHOLE, friction)
        np.testing.assert_allclose(part.points, whole.points, atol=1e-12)
        np.testing.assert_allclose(part.outward, whole.outward, atol=1e-7)
        heightmaps = heightmap_of(view, window), heightmap_of(view, WHOLE)
        for one, other in zip(*(heightmap or () for heightmap in heightmaps), strict=True):
            np.testing.assert_allclose(one, other, atol=1e-12)
        found.append((len(whole.points), view.depth[window].size < view.depth.size))
    edges, smaller = np.transpose(found)
    assert (edges > 0).sum() > 20
    assert smaller.sum() > 20


@pytest.mark.parametrize(("degrees", "found"), [(38.0, 1), (39.5, 0)])
def test_edges_oppose_each_other_within_the_friction_cone(degrees, found):
    """Silicone has a friction of 0.8, whose cone has a half angle of 38.7 degrees."""
    x, y = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    edges = _Edges(np.array([[-0.02, 0, 0.03], [0.02, 0, 0.03]]), np.array([[-x, y], [x, y]]))
    assert len(_pairs(edges, Gripper(opening=0.08)).axis) == found
