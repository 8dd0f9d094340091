"""Hulls of fewer corners, and hulls with lowered faces."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from egad.geometry.hulls import fewer_vertices, hull_of, lower_planes


def outside(points: np.ndarray, of: np.ndarray) -> float:
    planes = ConvexHull(of).equations
    return float((points @ planes[:, :3].T + planes[:, 3]).max())


@pytest.mark.parametrize("most", [4, 10, 64])
def test_corners_are_kept_up_to_the_number_allowed(most: int) -> None:
    hull = hull_of(trimesh.creation.icosphere(3, 0.03).vertices)
    fewer, is_near = fewer_vertices(hull, most, 0.0, 0.0)
    assert len(fewer.points) == most
    assert not is_near
    assert np.isin(fewer.points, hull.points).all()
    assert fewer.volume == pytest.approx(ConvexHull(fewer.points).volume)


def test_corners_are_left_out_within_the_distance_and_the_volume() -> None:
    hull = hull_of(trimesh.creation.icosphere(3, 0.03).vertices)
    by_distance, is_near = fewer_vertices(hull, 9999, 0.001, 1.0)
    assert is_near
    assert len(by_distance.points) < 200
    assert 0.0005 < outside(hull.points, by_distance.points) <= 0.001
    by_volume, is_near = fewer_vertices(hull, 9999, 1.0, 0.02)
    assert is_near
    assert 0.98 * hull.volume <= by_volume.volume < 0.99 * hull.volume


def test_all_corners_of_a_box_with_points_on_its_faces_are_kept() -> None:
    box = trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    fewer, is_near = fewer_vertices(hull_of(np.asarray(box.vertices)), 8, 1e-9, 1e-9)
    assert is_near
    assert fewer.volume == pytest.approx(6)


def test_a_lowered_face_takes_a_slice_off_and_nothing_is_left_of_a_plate() -> None:
    planes = hull_of(trimesh.creation.box((2, 2, 2)).vertices).planes
    by = np.where(planes[:, 2] > 0.9, 0.25, 0.0)
    corners = lower_planes(planes, by, np.zeros(3))
    assert corners is not None
    assert hull_of(corners).volume == pytest.approx(8 - 0.25 * 4)
    assert corners[:, 2].max() == pytest.approx(0.75)
    assert lower_planes(planes, np.full(len(planes), 1.1), np.zeros(3)) is None
