import numpy as np
import pytest

from egad.learning.dataset import LearningSet, Rule, Stream, example, order

RULE = Rule(0.002, 0.02)


@pytest.fixture(scope="module")
def shards(images):
    return LearningSet(images, RULE)


def test_a_pass_shows_each_training_image_once(shards):
    train = shards.numbers("train")
    part = shards.index.loc[train]
    first, second = order(part, 0, 0), order(part, 0, 1)
    assert sorted(first) == sorted(second) == train.tolist()
    assert first.tolist() != second.tolist()
    assert first.tolist() == order(part, 0, 0).tolist()
    assert first.tolist() != order(part, 1, 0).tolist()


def test_few_groups_are_open_at_a_time(shards, monkeypatch):
    """Images are shuffled within windows of whole groups."""
    monkeypatch.setattr("egad.learning.dataset.WINDOW", 20)
    index = shards.index
    group = index.groupby(["shard", "group"]).ngroup()
    shuffled = order(index, 3, 0)
    assert sorted(shuffled) == list(range(60))
    open_at = {name: np.flatnonzero(group[shuffled] == name) for name in set(group)}
    assert all(places.max() - places.min() < 20 + 2 * 16 for places in open_at.values())
    assert any(np.diff(places).max() > 1 for places in open_at.values())


def test_an_example_depends_on_its_number_alone(shards):
    forth = [Stream(shards, 100, seed=1)[number] for number in (0, 50, 99)]
    stream = Stream(shards, 100, seed=1)
    for number, (seen, wanted) in zip((99, 50, 0), forth[::-1], strict=True):
        again = stream[number]
        np.testing.assert_array_equal(again[0], seen)
        np.testing.assert_array_equal(again[1], wanted)
    assert not np.array_equal(Stream(shards, 100, seed=2)[0][0], forth[0][0])


def test_a_stream_has_an_end(shards):
    stream = Stream(shards, 3)
    assert len(stream) == 3
    assert len(list(stream)) == 3
    with pytest.raises(IndexError):
        stream[3]


def test_an_example_is_what_networks_take(shards):
    seen, wanted = Stream(shards, 100)[5]
    assert (seen.shape, wanted.shape) == ((1, 300, 300), (4, 300, 300))
    assert seen.dtype == wanted.dtype == np.float32
    assert np.isfinite(seen).all()
    assert abs(seen.mean()) < 1e-3


def test_an_image_without_a_good_grasp_is_a_negative(shards):
    depth, rectangles = shards.image(0)
    assert len(rectangles) == 0
    assert not example(depth, rectangles)[1].any()


def test_grasps_stay_on_the_object_whatever_is_changed(shards):
    """Where the quality is 1, what is seen is mostly the object, which is nearer than the mean."""
    stream = Stream(shards, 120, seed=4)
    shares = []
    for number in range(0, 120, 6):
        seen, wanted = stream[number]
        if wanted[0].any():
            shares.append((seen[0][wanted[0] == 1] < 0).mean())
    assert len(shares) > 8
    assert np.mean(shares) > 0.9
