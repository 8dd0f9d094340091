"""Cuts of a solid into parts."""

import numpy as np

from egad.geometry.cuts import volume_after
from egad.geometry.manifold import box

X = np.array([1.0, 0.0, 0.0])


def test_a_cut_with_nothing_on_one_side_is_the_worst():
    """Planes are halfway along the bounding box, which may have a needle without volume."""
    cube = box(np.zeros(3), np.ones(3))
    assert volume_after(cube, (X, 1.5)) == np.inf
    assert volume_after(cube, (X, 0.5)) < np.inf


def test_the_volume_after_a_cut_is_that_of_hulls():
    """Half of a cross is a T, of which one more cut makes two boxes."""
    size = np.array([1.5, 0.5, 0.5])
    cross = box(-size, size) + box(-size[[1, 0, 2]], size[[1, 0, 2]])
    assert cross.volume() - 1e-9 <= volume_after(cross, (X, 0.0)) < cross.hull().volume()
