"""What an outline alone suggests: the middle, across the narrower side."""

import numpy as np
import pytest

from egad.learning.dataset import ImageDataset, PositiveFilter
from egad.learning.evaluation import narrow_side_grasp, outline_score
from egad.learning.images import agrees


@pytest.mark.parametrize("angle", [-1.2, -0.4, 0.0, 0.7, 1.5])
def test_a_bar_is_grasped_across_its_middle(angle):
    u, v = np.meshgrid(np.arange(300) - 120.0, np.arange(300) - 170.0)
    narrow = np.cos(angle) * u - np.sin(angle) * v
    long = np.sin(angle) * u + np.cos(angle) * v
    found = narrow_side_grasp((np.abs(narrow) <= 15) & (np.abs(long) <= 50))
    np.testing.assert_allclose(found[:2], [120, 170], atol=0.2)
    assert found[2] == pytest.approx(angle, abs=0.01)
    assert found[3] == pytest.approx(31, abs=1.5)


def test_images_are_counted_in_which_it_is_right(images):
    """By looking at each image; those without a positive grasp never count."""
    shards = ImageDataset([images], PositiveFilter(0.002, 0.02))
    numbers = range(len(shards.index))
    expected = 0
    for number in numbers:
        truth = shards.image(number)[1]
        expected += len(truth) > 0 and agrees(narrow_side_grasp(shards.mask(number)), truth)
    good = (shards.index["positive"] > 0).sum()
    assert outline_score(shards, numbers) == (expected, good)
    assert 0 < expected <= good
    empty = np.flatnonzero(shards.index["positive"] == 0)
    assert outline_score(shards, empty) == (0, 0)
    shards.index["objects"] = [["a", "b"], *list(shards.index["objects"])[1:]]
    assert outline_score(shards, [0]) == (0, 0)
