"""The model card of a network trained on labelled scenes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from egad._util.markdown import filled, table
from egad.learning.model_card import counts, versions
from egad.learning.scene_scores import DECISION_THRESHOLD, SceneEstimate, SceneScore

COUNTS = ("objects", "packed", "piles", "without a positive grasp", "grasps", "positive")


@dataclass(frozen=True)
class TrainedOnScenes:
    """What the card tells about a network: the score is on `test`, settings are by name."""

    title: str
    parameters: int
    source: str
    gripper: str
    index: pd.DataFrame
    history: pd.DataFrame
    score: SceneScore
    settings: Mapping[str, Any]


def scene_card(trained: TrainedOnScenes) -> str:
    """The model card as Markdown; it holds no time, so the same training gives the same card."""
    score, history = trained.score, trained.history["validation_average_precision"].to_numpy()
    # the epoch whose weights are the result: the last one if none has a score
    best = int(np.nanargmax(history)) if np.isfinite(history).any() else len(history) - 1
    return filled(
        __package__,
        "scene_model_card.md",
        trained=trained,
        score=score,
        scores=table(["", "value", "from", "to"], _rows(score)),
        threshold=DECISION_THRESHOLD,
        validation=trained.history["validation_loss"][best],
        thresholds=table(
            ["quality at least", "recall", "precision"],
            [
                (threshold, f"{found:.1%}", f"{right:.1%}" if right == right else "")
                for threshold, found, right in zip(
                    score.thresholds, score.recall, score.precision, strict=True
                )
            ],
        ),
        data=table(["split", *COUNTS], counts(trained.index, ("packed", "pile"))),
        noise=_noise(trained.index),
        examples=int(trained.history["scenes"].iloc[-1]),
        epochs=len(trained.history),
        best=best,
        settings=table(["setting", "value"], trained.settings.items()),
        versions=table(["program", "version"], versions()),
    )


def _rows(score: SceneScore) -> list[tuple[str, str, str, str]]:
    return [
        _row("average precision", score.average_precision, "{:.3f}"),
        _row("balanced accuracy at 0.5", score.balanced_accuracy, "{:.1%}"),
        _row("mean error of the rotation, degrees", score.angle, "{:.1f}"),
        _row("mean error of the width, mm", score.width, "{:.1f}", 1000),
    ]


def _row(
    name: str, estimate: SceneEstimate, form: str, scale: float = 1
) -> tuple[str, str, str, str]:
    value, low, high = (form.format(scale * each) for each in (estimate.value, *estimate.interval))
    return name, value, low, high


def _noise(index: pd.DataFrame) -> str:
    low, high = index["views"].min(), index["views"].max()
    counts = index["noise"].value_counts().sort_index()
    noise = ", ".join(f"{name} in {count:,} scenes" for name, count in counts.items())
    cameras = f"{low}" if low == high else f"{low} to {high}"
    return f"Cameras in each scene: {cameras}. Noise of their images: {noise}."
