"""The model card of a trained network: what it was trained on, how, and how good it is."""

import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import pandas as pd

from egad import __version__
from egad._util.markdown import table
from egad.learning.evaluation import OutlineScore, Score
from egad.learning.images import SPLITS

PACKAGES = ("torch", "safetensors", "numpy", "scipy", "pillow")
PAGE = """# {title}, trained on {source}

A fully convolutional network of {parameters:,} weights. For every pixel of a depth image it says
how good a grasp there is, at which angle, and how wide (Morrison, Corke and Leitner, "Learning
robust, real-time, reactive robotic grasping", IJRR 2020). The weights are in `weights.safetensors`.

The input, (1, 300, 300), is depths in metres, gaps filled, less their mean, clipped to [-1, 1]. The
output, (4, 300, 300), is quality, cos 2a, sin 2a and opening / 150 pixels, where the angle a of the
closing axis is counterclockwise as seen from the image's x axis.

## Score

The best grasp is correct in {right:,} of {count:,} images of {objects:,} held-out objects, those of
the split `test`: {rate:.1%}, for other objects and scenes of the same kind {low:.1%} to {high:.1%}
(95 %). In the {alone:,} images of a single object, a grasp of its middle across its narrower side
is correct in {plain:,}. The loss is {loss:.4f}, that on the validation set {validation:.4f}.

The best grasp, at the highest peak, is correct if it overlaps a positive one by more than 0.25
(intersection over union) with axes less than 30 degrees apart. Images without a positive grasp do
not count. No object is in two splits.

## Data

{data}
A grasp is positive if it is free of collision and {rule}. Images without a
positive grasp, if there are any, are examples where nothing can be grasped.

## Training

{images:,} examples in {epochs} epochs.

![Losses and score](history.svg)

{settings}
## Versions

{versions}"""


@dataclass(frozen=True)
class TrainedNetwork:
    """What the card tells about a network: scores are on the split `test`, settings by name."""

    title: str
    parameters: int
    source: str
    index: pd.DataFrame
    history: pd.DataFrame
    score: Score
    outline: OutlineScore
    settings: Mapping[str, Any]


def card(trained: TrainedNetwork) -> str:
    """The model card as Markdown; it holds no time, so the same training gives the same card."""
    score, last = trained.score, trained.history.iloc[-1]
    return PAGE.format(
        title=trained.title,
        parameters=trained.parameters,
        source=trained.source,
        right=score.n_correct,
        count=score.n_images,
        objects=score.objects,
        rate=score.rate,
        plain=trained.outline.n_correct,
        alone=trained.outline.n_images,
        low=score.interval[0],
        high=score.interval[1],
        loss=score.loss,
        validation=last["validation_loss"],
        data=table(
            ["split", "objects", "images", "without a positive grasp", "grasps", "positive"],
            counts(trained.index),
        ),
        rule="succeeded in simulation"
        if trained.settings["positive"] == "simulated"
        else f"has a robust quality above {trained.settings['quality']}",
        images=int(last["images"]),
        epochs=len(trained.history),
        settings=table(["setting", "value"], trained.settings.items()),
        versions=table(["program", "version"], versions()),
    )


def counts(index: pd.DataFrame, kinds: Sequence[str] = ()) -> list[tuple[str | int, ...]]:
    """Objects, images or scenes of each kind, those with no positive grasp, grasps, positive."""
    parts = [(split, index[index["split"] == split]) for split in SPLITS]
    return [
        (
            split,
            part["objects"].explode().nunique(),
            *([int((part["kind"] == kind).sum()) for kind in kinds] or [len(part)]),
            int((part["positive"] == 0).sum()),
            int(part["grasps"].sum()),
            int(part["positive"].sum()),
        )
        for split, part in parts
    ]


def versions() -> list[tuple[str, str]]:
    """Versions of everything that the numbers depend on."""
    found = [("egad", __version__), ("python", platform.python_version())]
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            found.append((name, version(name)))
    return found
