"""The model card of a trained network: what it was trained on, how, and how good it is."""

import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import pandas as pd

from egad import __version__
from egad._util.markdown import filled, table
from egad.learning.evaluation import OutlineScore, Score
from egad.learning.images import SPLITS

PACKAGES = ("torch", "safetensors", "numpy", "scipy", "pillow")


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
    return filled(
        __package__,
        "model_card.md",
        trained=trained,
        score=score,
        last=last,
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
