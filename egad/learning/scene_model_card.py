"""The model card of a network trained on labelled scenes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from egad._util.markdown import table
from egad.learning.model_card import counts, versions
from egad.learning.scene_scores import DECISION_THRESHOLD, SceneEstimate, SceneScore

PAGE = """# {title}, trained on {source}

A fully convolutional network of {parameters:,} weights. For every voxel of a truncated signed
distance field it says how good a grasp there is, how the hand is turned, and how wide it holds
(Breyer et al., "Volumetric grasping network", CoRL 2020). The weights are in `weights.safetensors`,
for the detector `vgn`. It was trained on grasps of {gripper}. How well it grasps with another hand
is not measured here: the detector tells the network nothing about the hand that it is used with.

The input, (1, 40, 40, 40), is distances from 0 inside to 1 outside, 0 where nothing is seen or near
no surface. The output, (6, 40, 40, 40), is quality, quaternion (x, y, z, w) and width in voxels, of
a hand that closes along y, with its origin 5 cm before the fingertips.

## Score

On {scenes:,} scenes of held-out objects, those of the split `test`, seen by all their cameras, with
{grasps:,} labelled grasps of which {share:.1%} succeeded. Intervals (95 %) are for other scenes of
the same kind.

{score}
Guesses have an average precision equal to the share of grasps that succeeded, and a balanced
accuracy of 50 %. The rotation is that of the hand, compared with the nearest one at which it held,
at grasps that succeeded. The loss is {loss:.4f}, that on the validation set {validation:.4f}.

The quality is that of a set in which as many grasps succeed as fail. The detector smooths it, which
lowers its peaks, and proposes what is left above `threshold`, {threshold} by default for these
weights. At the labelled voxels, before smoothing:

{thresholds}
## Data

{data}
{noise}
A grasp is positive if it succeeded in the simulated scene. No object is in two splits.

## Training

{examples:,} examples in {epochs} epochs. Each is a scene with all its grasps, seen by one to all of
its cameras. The weights are those after epoch {best}, with the highest average precision on the
validation set.

![Losses and average precision](history.svg)

{settings}
## Versions

{versions}"""


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
    return PAGE.format(
        title=trained.title,
        parameters=trained.parameters,
        source=trained.source,
        gripper=trained.gripper,
        scenes=score.scenes,
        grasps=score.grasps,
        share=score.share,
        score=table(["", "value", "from", "to"], _rows(score)),
        threshold=DECISION_THRESHOLD,
        loss=score.loss,
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
