"""Average precision and errors at labelled grasps, against slow and obvious twins."""

import numpy as np
import pytest

from egad.learning.scene_scores import (
    GraspAnswers,
    average_precision,
    joint_average_precision,
    scene_score,
)


def slow_precision(success, quality):
    """For each threshold from the highest: precision times the rise in recall."""
    before, area = 0, 0.0
    for threshold in sorted(set(quality), reverse=True):
        above = [s for s, q in zip(success, quality, strict=True) if q >= threshold]
        area += sum(above) / len(above) * (sum(above) - before) / sum(success)
        before = sum(above)
    return area


@pytest.mark.parametrize("seed", range(20))
def test_average_precision_is_that_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 40))
    success = rng.random(count) < 0.4
    success[0] = True
    quality = rng.integers(0, 8, count) / 8  # with ties
    assert average_precision(success, quality) == pytest.approx(slow_precision(success, quality))


def test_values_of_average_precision_that_are_known():
    """The example of the documentation of scikit-learn, the best, the worst and no order."""
    good = np.array([False, False, True, True])
    assert average_precision(good, np.array([0.1, 0.4, 0.35, 0.8])) == pytest.approx(
        0.8333, abs=1e-4
    )
    assert average_precision(good, np.arange(4.0)) == 1
    assert average_precision(good, -np.arange(4.0)) == pytest.approx((1 / 3 + 2 / 4) / 2)
    assert average_precision(good, np.zeros(4)) == 0.5
    assert np.isnan(average_precision(good[:2], np.zeros(2)))
    assert np.isnan(average_precision(good[:0], np.zeros(0)))


def answers(seed, scenes=12, grasps=15):
    """Answers that are right more often than not; one scene has no grasps at all."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(scenes):
        count = 0 if number == 3 else grasps
        success = rng.random(count) < rng.uniform(0.1, 0.6)
        quality = np.clip(0.35 * success + rng.random(count) * 0.65, 0, 1)
        errors = rng.random((2, count))
        losses = rng.random((count, 3))
        found.append(GraspAnswers(success, quality, 90 * errors[0], 0.01 * errors[1], losses))
    return found


def test_the_score_is_that_of_all_grasps():
    found = answers(0)
    success, quality, angles, widths = (
        np.concatenate([each[k] for each in found]) for k in range(4)
    )
    score = scene_score(found)
    assert (score.scenes, score.grasps, score.positive) == (12, 165, success.sum())
    assert score.share == success.mean()
    assert (
        score.average_precision.value
        == average_precision(success, quality)
        == joint_average_precision(found)
    )
    right = (quality >= 0.5) == success
    balanced = (right[success].mean() + right[~success].mean()) / 2
    assert score.balanced_accuracy.value == pytest.approx(balanced)
    assert score.angle.value == pytest.approx(angles[success].mean())
    assert score.width.value == pytest.approx(widths[success].mean())
    assert score.loss == pytest.approx(np.concatenate([each.losses for each in found]).sum() / 165)
    for threshold, recall, precision in zip(
        score.thresholds, score.recall, score.precision, strict=True
    ):
        above = quality >= threshold
        assert recall == (above & success).sum() / success.sum()
        assert precision == pytest.approx((above & success).sum() / above.sum())


def test_intervals_are_those_of_drawn_scenes(monkeypatch):
    """The slow way: join the grasps of the scenes that are drawn, and score them anew."""
    monkeypatch.setattr("egad.bench.stats.rates.DRAWS", 60)
    found, seen = answers(1), []

    def watched(statistic, count):
        draws = np.random.default_rng(0).integers(count, size=(60, count))
        seen.append((draws, statistic(draws)))
        return 0.0, 1.0

    monkeypatch.setattr("egad.learning.scene_scores.bootstrap", watched)
    scene_score(found)
    for draws, values in seen:
        assert draws.shape == (60, 12)
        assert values.shape == (60,)
    for draw, precision, balanced in zip(seen[0][0], seen[0][1], seen[1][1], strict=True):
        drawn = [found[number] for number in draw]
        assert precision == pytest.approx(joint_average_precision(drawn))
        with_these = scene_score_value(drawn)
        assert balanced == pytest.approx(with_these)


def scene_score_value(drawn):
    success, quality = (np.concatenate([each[k] for each in drawn]) for k in range(2))
    right = (quality >= 0.5) == success
    return (right[success].mean() + right[~success].mean()) / 2
