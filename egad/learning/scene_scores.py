"""How good VGN's network is at labelled grasps of scenes: average precision, and errors (ours)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad.bench.stats import Interval, bootstrap
from egad.tables.training import SCENE_SCORE

DECISION_THRESHOLD = 0.5  # quality from which a grasp is predicted to succeed
THRESHOLDS = (0.5, 0.7, 0.8, 0.9, 0.95)


class GraspAnswers(NamedTuple):
    """What a network answers at m labelled grasps of a scene: quality, and errors."""

    success: NDArray[np.bool_]
    quality: Floats
    angles: Floats  # (m,) between the predicted rotation and the nearest one that holds, degrees
    widths: Floats  # (m,) how far the predicted width is off, metres
    losses: Floats  # (m, 3) of quality, rotation and width, weighted


@dataclass(frozen=True)
class SceneEstimate:
    """A statistic of some scenes, and its 95 % interval for other scenes of the same kind."""

    value: float
    interval: Interval


@dataclass(frozen=True)
class SceneScore:
    """What a network reached on scenes of held-out objects."""

    scenes: int
    grasps: int
    positive: int
    average_precision: SceneEstimate  # of the quality; that of guesses is the share of positives
    # mean of the fractions of the positive and of the negative grasps that are classified correctly
    # at a quality of 0.5
    balanced_accuracy: SceneEstimate
    angle: SceneEstimate  # mean error of the rotation at positive grasps, degrees
    width: SceneEstimate  # mean error of the width at positive grasps, metres
    loss: float  # mean over the grasps
    thresholds: tuple[float, ...]  # thresholds of the quality, for the next two
    recall: tuple[float, ...]  # fraction of the positive grasps with at least that quality
    # fraction of the grasps of that quality that are positive; NaN if there are none
    precision: tuple[float, ...]

    @property
    def share(self) -> float:
        """Fraction of the grasps that is positive."""
        return self.positive / self.grasps if self.grasps else np.nan


def average_precision(success: NDArray[np.bool_], quality: Floats) -> float:
    """Precision times rise in recall, summed over distinct qualities; NaN without positives."""
    ranked = np.argsort(-quality, kind="stable")
    return _ranked_average_precision(success[ranked], np.ones(len(ranked)), _ends(quality[ranked]))


def _ends(ranked: Floats) -> NDArray[np.int64]:
    """The last index of each run of equal qualities."""
    return np.flatnonzero(np.append(np.diff(ranked) != 0, True)) if len(ranked) else np.arange(0)


def _ranked_average_precision(
    success: NDArray[np.bool_], weights: Floats, ends: NDArray[np.int64]
) -> float:
    """The average precision of ranked grasps, each as often as its weight says."""
    right, shown = np.cumsum(weights * success)[ends], np.cumsum(weights)[ends]
    if not len(ends) or right[-1] == 0:
        return np.nan
    with np.errstate(invalid="ignore"):
        precision = np.nan_to_num(right / shown)  # grasps before the first that counts
    return float(np.diff(right, prepend=0.0) @ precision / right[-1])


def scene_score(answers: Sequence[GraspAnswers]) -> SceneScore:
    """Combine the answers to some scenes; the intervals are for other scenes."""
    success, quality = _joined(answers, "success").astype(bool), _joined(answers, "quality")
    at_least = [quality >= threshold for threshold in THRESHOLDS]
    return SceneScore(
        scenes=len(answers),
        grasps=len(success),
        positive=int(success.sum()),
        average_precision=_average_precision_estimate(answers, success, quality),
        balanced_accuracy=_balanced_accuracy(answers),
        angle=_mean_estimate([each.angles[each.success] for each in answers]),
        width=_mean_estimate([each.widths[each.success] for each in answers]),
        loss=mean_loss(answers),
        thresholds=THRESHOLDS,
        recall=tuple(_mean(chosen[success]) for chosen in at_least),
        precision=tuple(_mean(success[chosen]) for chosen in at_least),
    )


def mean_loss(answers: Sequence[GraspAnswers]) -> float:
    """The sum of the losses, as the mean over all grasps; NaN without any."""
    return _mean(np.concatenate([each.losses.sum(axis=1) for each in answers]))


def joint_average_precision(answers: Sequence[GraspAnswers]) -> float:
    """The average precision over the grasps of all scenes."""
    return average_precision(_joined(answers, "success").astype(bool), _joined(answers, "quality"))


def scene_score_table(score: SceneScore) -> pd.DataFrame:
    """The score as a table of one row, columns of `tables.training.SCENE_SCORE`."""
    row = {
        "n_scenes": score.scenes,
        "n_grasps": score.grasps,
        "n_positive": score.positive,
        "loss": score.loss,
    }
    named = {
        "average_precision": score.average_precision,
        "balanced_accuracy": score.balanced_accuracy,
        "angle_error": score.angle,
        "width_error": score.width,
    }
    for name, estimate in named.items():
        low, high = estimate.interval
        row |= {name: estimate.value, f"{name}_ci_low": low, f"{name}_ci_high": high}
    return pd.DataFrame([row], columns=SCENE_SCORE.names)


def _joined(answers: Sequence[GraspAnswers], name: str) -> Floats:
    return np.concatenate([np.asarray(getattr(each, name), np.float64) for each in answers])


def _mean(values: NDArray[np.floating] | NDArray[np.bool_]) -> float:
    return float(values.mean()) if len(values) else np.nan


def _average_precision_estimate(
    answers: Sequence[GraspAnswers], success: NDArray[np.bool_], quality: Floats
) -> SceneEstimate:
    """The average precision, and its interval by resampling scenes."""
    ranked = np.argsort(-quality, kind="stable")
    scene = np.repeat(np.arange(len(answers)), [len(each.success) for each in answers])[ranked]
    ends, right = _ends(quality[ranked]), success[ranked]

    def of_draws(draws: NDArray[np.int64]) -> Floats:
        counts = (np.bincount(draw, minlength=len(answers)).astype(float) for draw in draws)
        return np.array([_ranked_average_precision(right, count[scene], ends) for count in counts])

    return SceneEstimate(average_precision(success, quality), bootstrap(of_draws, len(answers)))


def _balanced_accuracy(answers: Sequence[GraspAnswers]) -> SceneEstimate:
    """The mean of the fractions of both classes that are classified correctly at 0.5."""
    sums = np.array(
        [
            [(high & good).sum(), good.sum(), (~high & ~good).sum(), (~good).sum()]
            for good, high in (
                (each.success, each.quality >= DECISION_THRESHOLD) for each in answers
            )
        ],
        dtype=np.float64,
    )

    def of_sums(found: Floats) -> Floats:
        both: Floats = (found[..., 0] / found[..., 1] + found[..., 2] / found[..., 3]) / 2
        return both

    return _estimate(sums, of_sums)


def _mean_estimate(values: Sequence[Floats]) -> SceneEstimate:
    sums = np.array([[each.sum(), len(each)] for each in values], dtype=np.float64)
    return _estimate(sums, lambda found: np.asarray(found[..., 0] / found[..., 1]))


def _estimate(sums: Floats, statistic: Callable[[Floats], Floats]) -> SceneEstimate:
    """A statistic of sums over scenes, given (n, k) numbers of the scenes."""
    with np.errstate(invalid="ignore"):
        interval = bootstrap(lambda draws: statistic(sums[draws].sum(axis=1)), len(sums))
        return SceneEstimate(float(statistic(sums.sum(axis=0))), interval)
