"""Grasps as arrays: choosing, sorting and moving them, against the table and plain algebra."""

import re

import numpy as np
import pytest
import trimesh

import egad
from egad.errors import UserError


@pytest.fixture(scope="module")
def grasps():
    box = trimesh.creation.box((0.03, 0.05, 0.07))
    return egad.sample_grasps(box, "panda", n=30)


@pytest.mark.parametrize(
    "chosen", [slice(5), slice(None, None, -3), np.array([4, 2, 2]), [7], 3, -1]
)
def test_choosing_is_that_of_arrays(grasps, chosen):
    expected = np.atleast_1d(grasps.quality[chosen])
    assert np.array_equal(grasps[chosen].quality, expected)
    assert len(grasps[chosen]) == len(expected)


def test_booleans_choose(grasps):
    good = grasps.quality > np.median(grasps.quality)
    assert np.array_equal(grasps[good].contacts, grasps.contacts[good])
    assert len(grasps[good & ~good]) == len(grasps[[]]) == 0
    with pytest.raises(IndexError):
        grasps[len(grasps)]


def test_sorting_is_descending_and_stable(grasps):
    best = grasps.sorted_by("robust_quality")
    order = np.argsort(-grasps.robust_quality, kind="stable")
    assert np.array_equal(best.widths, grasps.widths[order])
    with pytest.raises(UserError, match=r"no column 'qualty'; allowed: .*quality"):
        grasps.sorted_by("qualty")


def test_moving_grasps_multiplies_their_poses(grasps):
    matrix = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3))
    matrix[:3, 3] = 0.1, -0.2, 0.3
    moved = grasps.transformed(matrix)
    assert moved.poses == pytest.approx(matrix @ grasps.poses)
    assert moved.contacts == pytest.approx(
        trimesh.transform_points(grasps.contacts.reshape(-1, 3), matrix).reshape(-1, 2, 3)
    )
    assert np.linalg.norm(moved.normals, axis=2) == pytest.approx(1)
    assert np.array_equal(moved.quality, grasps.quality)
    back = moved.transformed(np.linalg.inv(matrix))
    assert back.normals == pytest.approx(grasps.normals)


@pytest.mark.parametrize(
    "matrix",
    [np.eye(3), 2 * np.eye(4), np.diag([1, 1, -1, 1]), np.full((4, 4), np.nan), np.eye(4)[::-1]],
)
def test_only_rigid_transforms_are_allowed(grasps, matrix):
    with pytest.raises(UserError, match=r"rigid|finite"):
        grasps.transformed(matrix)


@pytest.mark.parametrize("wrong", ["x", None, [[1.0], [1.0, 2.0]], 1.0])
def test_transforms_that_are_no_matrix_are_told(grasps, wrong):
    message = f"matrix is {wrong!r}; allowed: a (4, 4) array of finite numbers"
    with pytest.raises(UserError, match=re.escape(message)):
        grasps.transformed(wrong)


def test_the_table_is_a_copy(grasps):
    frame = grasps.to_frame()
    frame.loc[:, "quality"] = -1.0
    assert grasps.quality.min() >= 0


def test_grasps_of_one_object_have_no_labels(grasps):
    with pytest.raises(UserError, match="single object"):
        grasps.of("M14_3")
