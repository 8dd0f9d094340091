"""Detectors for suction cups choose flat places near the middle, where the cup seals."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

import egad
from egad.detectors import DepthCamera, Intrinsics, View, camera_above
from egad.detectors.base import SEARCH
from egad.detectors.labels import Labels
from egad.detectors.observation import PointCloud
from egad.detectors.suction import FLAT, TORQUE_SCALING, suction_cloud, suction_depth
from egad.geometry import RayCaster
from egad.grasps.suction import seal_cups
from egad.grippers import GRIPPERS

CUP = GRIPPERS["cup_30mm"]
RADIUS = 0.015
SHIFT = np.array([0.02, -0.03])
INTRINSICS, ABOVE = Intrinsics.spanning(640, 480, 75.0), camera_above(0.6)


def placed(mesh):
    """On the table, aside of the middle."""
    mesh = mesh.copy()
    low = np.append((mesh.bounds[0, :2] + mesh.bounds[1, :2]) / 2, mesh.bounds[0, 2])
    return mesh.apply_translation(np.append(SHIFT, 0.0) - low)


def view_of(mesh):
    return DepthCamera(mesh).render(np.eye(4), INTRINSICS, ABOVE)


def from_above(mesh):
    return suction_depth(view_of(placed(mesh)), CUP, np.random.default_rng(0))


def cloud_of(mesh, count=6000):
    points, faces = trimesh.sample.sample_surface(placed(mesh), count, seed=1)
    seen = points[:, 2] > 0.004
    return PointCloud(np.asarray(points)[seen], placed(mesh).face_normals[faces][seen])


def around(mesh):
    return suction_cloud(cloud_of(mesh), CUP, np.random.default_rng(0))


def steps():
    """A wide and a narrow step, 15 mm apart in height: only the wide one is larger than the cup."""
    wide = trimesh.creation.box((0.06, 0.06, 0.03)).apply_translation([0, 0, 0.015])
    narrow = trimesh.creation.box((0.02, 0.06, 0.045)).apply_translation([0.04, 0, 0.0225])
    return trimesh.boolean.union([wide, narrow], engine="manifold")


def plate_with_hole(radius):
    plate = trimesh.creation.box((0.1, 0.1, 0.03))
    hole = trimesh.creation.cylinder(radius, 0.1, sections=96)
    return trimesh.boolean.difference([plate, hole], engine="manifold")


BOX = trimesh.creation.box((0.07, 0.05, 0.04))


def test_the_best_place_of_a_box_is_the_middle_of_its_top():
    best, *others = from_above(BOX)
    np.testing.assert_allclose(best.center[:2], SHIFT, atol=0.003)
    assert best.center[2] == pytest.approx(0.04, abs=0.001)
    assert (best.width, best.depth) == (0.0, SEARCH)
    assert best.quality > 0.8
    assert all(each.quality <= best.quality for each in others)


def test_the_quality_is_that_of_the_formula():
    """On a level face nothing deviates: only the distance from the middle counts."""
    for each in from_above(BOX)[:20]:
        distance = np.linalg.norm(np.array(each.center[:2]) - SHIFT)
        expected = 1 / np.sqrt(1 + (TORQUE_SCALING * distance) ** 2)
        assert each.quality == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize(("angle", "found"), [(0.0, True), (0.12, True), (0.3, False)])
def test_a_top_must_be_level(angle, found):
    """The heights of a tilted disc deviate by tan(angle) / 2 times its radius."""
    tilted = BOX.copy().apply_transform(trimesh.transformations.rotation_matrix(angle, [0, 1, 0]))
    grasps = from_above(tilted)
    assert bool(grasps) == found
    if found and angle:
        flat = 1 - 1.1 * np.tan(angle) / 2 / FLAT
        assert grasps[0].quality == pytest.approx(flat, abs=0.1)


def test_the_ring_stays_on_one_step():
    """All of it lies on the wide one, away from the wall: the middle of the object would not do."""
    for each in from_above(steps()):
        x = each.center[0] - placed(steps()).bounds[0, 0]
        assert each.center[2] == pytest.approx(0.03, abs=0.001)
        assert RADIUS <= x <= 0.06 - RADIUS


@pytest.mark.parametrize("hole", [0.008, 0.02])
def test_no_ring_has_a_hole_inside(hole):
    grasps = from_above(plate_with_hole(hole))
    assert len(grasps) > 10
    for each in grasps:
        assert np.linalg.norm(np.array(each.center[:2]) - SHIFT) > RADIUS + hole - 0.003


@pytest.mark.parametrize(
    "mesh",
    [trimesh.creation.icosphere(4, 0.018), trimesh.creation.box((0.02, 0.06, 0.05))],
    ids=["a ball", "a bar"],
)
def test_what_is_too_round_or_too_narrow_has_no_place(mesh):
    assert from_above(mesh) == []
    assert from_above(mesh.copy().apply_scale(3.0)) != []


def test_an_empty_table_has_no_place():
    depth = np.full((480, 640), 0.6)
    assert suction_depth(View(depth, INTRINSICS, ABOVE), CUP, np.random.default_rng(0)) == []
    nothing = PointCloud(np.empty((0, 3)), np.empty((0, 3)))
    assert len(suction_cloud(nothing, CUP, np.random.default_rng(0)).poses) == 0


def test_the_cup_seals_at_the_best_places_of_boxes_and_steps():
    for mesh in (BOX, steps(), plate_with_hole(0.02)):
        caster = RayCaster(placed(mesh))
        down = np.diag([1.0, -1.0, -1.0])[None]
        for each in from_above(mesh)[:10]:
            assert seal_cups(caster, CUP.cup, np.array([each.center]), down).sealed[0]
        found = around(mesh)
        frames = np.ascontiguousarray(found.poses[:10, :3, :3].transpose(0, 2, 1))
        assert seal_cups(caster, CUP.cup, found.poses[:10, :3, 3], frames).sealed.all()


def test_the_best_place_of_a_cloud_is_the_middle_of_the_top():
    found = around(trimesh.creation.box((0.06, 0.06, 0.06)))
    best = found.poses[0]
    np.testing.assert_allclose(best[:3, 2], [0, 0, -1], atol=0.02)
    np.testing.assert_allclose(best[:2, 3], SHIFT, atol=0.006)
    np.testing.assert_allclose(best[:3, :3].T @ best[:3, :3], np.eye(3), atol=1e-12)
    assert (found.widths == 0).all()
    assert (np.diff(found.scores) <= 0).all()


def test_a_cloud_with_something_in_the_way_leaves_it_free():
    """A wall stands 5 mm beside the box: no cup comes through it."""
    box = trimesh.creation.box((0.06, 0.06, 0.06))
    wall = trimesh.creation.box((0.02, 0.2, 0.2)).apply_translation([0.045, 0, 0.07])
    both = trimesh.util.concatenate([box, wall])
    points = cloud_of(both, 20000).points
    tree, found = KDTree(points), around(both)
    assert len(found.poses)
    for pose in found.poses:
        axis = pose[:3, 3] - np.linspace(0.02, 0.1, 40)[:, None] * pose[:3, 2]
        assert tree.query(axis)[0].min() > 0.01


def test_labels_of_a_cup_are_those_that_come_straight_down():
    mesh = trimesh.creation.box((0.05, 0.06, 0.04))
    table = egad.sample_grasps(mesh, "cup_30mm", n=200).to_frame()
    pose = np.eye(4)
    pose[:3, 3] = [*SHIFT, 0.02]
    grasps = Labels(table).propose(pose, None, CUP)
    free = table[table["collision_free"] & (table["approach_z"] < -0.99)]
    free = free[free["robust_quality"] > 0]
    assert len(grasps) == min(len(free), 50) > 0
    best = free["robust_quality"].max()
    assert grasps[0].quality == pytest.approx(best)
    np.testing.assert_allclose([each.center[2] for each in grasps], 0.04, atol=1e-9)
    turned = pose @ trimesh.transformations.rotation_matrix(np.pi, [1, 0, 0])
    below = table[table["collision_free"] & (table["approach_z"] > 0.99)]
    assert len(Labels(table).propose(turned, None, CUP)) == min((below["quality"] > 0).sum(), 50)
