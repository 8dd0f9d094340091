"""The scores of a network and of an outline alone, and the model card that tells them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from egad.learning.dataset import ImageDataset, PositiveFilter
from egad.learning.evaluation import (
    ImageScore,
    OutlineScore,
    Score,
    narrow_side_grasp,
    outline_score,
    total_score,
)
from egad.learning.images import agrees
from egad.learning.model_card import TrainedNetwork, card, counts
from egad.report.training import training_chart


@pytest.fixture
def history():
    losses = {"loss": [0.03, 0.02, 0.01], "validation_loss": [0.04, 0.02, 0.03]}
    score = {"validation_score": [float("nan"), 0.5, 0.6]}
    return pd.DataFrame({"epoch": [0, 1, 2], "images": [1000, 2000, 3000], **losses, **score})


def test_counts_are_of_objects_images_negatives_and_grasps(images, pictures):
    found = {
        row[0]: row[1:] for row in counts(ImageDataset([images], PositiveFilter(0.002, 0.02)).index)
    }
    for split, (objects, shown, empty, grasps, positive) in found.items():
        rows = [row for row in pictures if row["split"] == split]
        assert objects == len({row["id"] for row in rows})
        assert (shown, empty) == (len(rows), len(rows) // 3)
        assert grasps == sum(len(row["u"]) for row in rows)
        assert positive == sum(len(row["u"]) - 2 for n, row in enumerate(rows) if n % 3)


def test_a_scene_is_not_an_object():
    """Images of scenes have an id of their own, and the objects that they show."""
    rows = [("a", ["a"]), ("b", ["b"]), ("scene", ["a", "b", "c"]), ("scene", ["a", "b", "c"])]
    index = pd.DataFrame(rows, columns=["id", "objects"]).assign(split="test", grasps=4, positive=2)
    found = {split: objects for split, objects, *_ in counts(index)}
    assert found == {"train": 0, "validation": 0, "test": 3}
    hits = [True, False, True, None]
    score = total_score(index, [ImageScore(np.zeros(4), hit) for hit in hits])
    assert (score.n_correct, score.n_images, score.objects) == (2, 3, 3)
    assert (
        total_score(index.head(2), [ImageScore(np.zeros(4), hit) for hit in hits[:2]]).objects == 2
    )


def test_the_card_tells_the_score_and_the_losses_of_the_last_epoch(images, history):
    index = ImageDataset([images], PositiveFilter(0.002, 0.02)).index
    score = Score(n_correct=30, n_images=40, objects=7, interval=(0.6, 0.85), loss=0.0234)
    settings = {"positive": "quality", "quality": 0.002}
    trained = TrainedNetwork(
        "GG-CNN", 62420, "pictures", index, history, score, OutlineScore(22, 31), settings
    )
    text = card(trained)
    assert "correct in 30 of 40 images of 7 held-out objects" in text
    assert "75.0%, for other objects and scenes of the same kind 60.0% to 85.0%" in text
    assert "the 31 images of a single object" in text
    assert "is correct in 22." in text
    assert "3,000 examples in 3 epochs" in text
    assert "validation set 0.0300" in text
    assert "has a robust quality above 0.002." in text
    simulated = replace(trained, settings=settings | {"positive": "simulated"})
    assert "free of collision and succeeded in simulation." in card(simulated)
    assert text.count("| quality | 0.002 |") == 1


def test_the_chart_is_the_same_for_the_same_history(history):
    assert training_chart(history) == training_chart(history)


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
