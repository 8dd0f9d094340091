import numpy as np
import pytest

from egad.errors import UserError
from egad.evolution import voxels


def box(*slices, size=9):
    solid = np.zeros((size,) * 3, bool)
    for part in slices:
        solid[part] = True
    return solid


def slow_fill(solid):
    """Look along every axis from both sides, voxel by voxel."""
    filled = solid.copy()
    for i, j, k in np.ndindex(solid.shape):
        lines = [(solid[:, j, k], i), (solid[i, :, k], j), (solid[i, j, :], k)]
        filled[i, j, k] |= all(line[:at].any() and line[at + 1 :].any() for line, at in lines)
    return filled


def test_filling_equals_looking_along_every_axis():
    noise = np.random.default_rng(0).random((7, 8, 9)) < 0.3
    assert np.array_equal(voxels.fill_orthographic(noise), slow_fill(noise))


def test_a_void_is_filled_and_a_tunnel_is_not():
    hollow = box(np.s_[1:8, 1:8, 1:8])
    hollow[3:6, 3:6, 3:6] = False
    assert voxels.fill_orthographic(hollow)[4, 4, 4]
    tunnel = box(np.s_[1:8, 1:8, 1:8])
    tunnel[3:6, 3:6, :] = False
    assert not voxels.fill_orthographic(tunnel)[4, 4, 4]


def test_largest_body_keeps_the_bigger_one():
    two = box(np.s_[0:2, 0:2, 0:2], np.s_[4:8, 4:8, 4:8])
    kept = voxels.largest_body(two)
    assert kept.sum() == 64
    assert not kept[0, 0, 0]


@pytest.mark.parametrize("size", [8, 9, 25])
def test_pack_round_trip(size):
    solid = np.random.default_rng(size).random((size,) * 3) < 0.5
    assert np.array_equal(voxels.unpack(voxels.pack(solid), size), solid)


def test_unpack_refuses_another_resolution():
    with pytest.raises(UserError, match=r"25\^3"):
        voxels.unpack(b"123", 25)


def test_identity_tells_solids_apart():
    one = box(np.s_[2:5, 2:5, 2:5])
    other = box(np.s_[2:5, 2:5, 2:6])
    assert voxels.identity(one) == voxels.identity(one.copy())
    assert voxels.identity(one) != voxels.identity(other)
