"""The tables of the README, from what `sources.py` kept: `python sources_page.py OUT`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sources import ENGINES, SEEDS, SOURCES

from egad.bench.hands import HandComparison
from egad.random import generator

COUNTED = ["best", "detector"]  # graspers
DRAWS = 4000
GROUPS = ("evolved", "primitives", "ycb", "household")
Scores = NDArray[np.float64]  # (designs, objects)


def scores_of(out: Path, hand: str, which: str) -> pd.Series:
    """Score of a hand at each object: mean of graspers, engines and drops."""
    parts = [
        HandComparison.load(out / hand / engine / f"{which}.parquet").table for engine in ENGINES
    ]
    table = pd.concat(parts)
    counted = table[table["grasper"].isin(COUNTED)]
    return counted.groupby(["label", "engine", "grasper"])["success"].mean().groupby("label").mean()


def group_of(label: str) -> str:
    """The group of an object that hands are judged at."""
    if label.startswith("primitive "):
        return "primitives"
    if label[:3].isdigit():
        return "ycb"
    return "evolved" if len(label) == 2 else "household"


def weighted(scores: Scores, groups: list[NDArray[np.int64]]) -> float:
    """Mean over designs and groups of objects, in which each group counts the same."""
    return float(np.mean([scores[:, members].mean() for members in groups]))


def difference(
    one: Scores, other: Scores, groups: list[NDArray[np.int64]], purpose: str
) -> tuple[float, float, float]:
    """Mean difference, and its 95 % interval over designs and objects within groups."""
    rng = generator(0, "sources of tips", purpose)
    found = []
    for _ in range(DRAWS):
        drawn = [rng.choice(members, len(members)) for members in groups]
        pair = [each[rng.integers(len(each), size=len(each))] for each in (one, other)]
        found.append(weighted(pair[0], drawn) - weighted(pair[1], drawn))
    low, high = np.percentile(found, [2.5, 97.5])
    return weighted(one, groups) - weighted(other, groups), float(low), float(high)


def main(out: Path) -> None:
    """Print the scores by group of objects, and the differences."""
    for hand in sorted(path.name for path in out.iterdir() if path.is_dir()):
        built = scores_of(out, hand, "as-built")
        labels = list(built.index)
        groups = [np.flatnonzero([group_of(e) == g for e in labels]) for g in GROUPS]
        scores = {"as built": built.to_numpy(float)[None]}
        for source in SOURCES:
            made = [scores_of(out, hand, f"{source}-{seed}")[labels] for seed in SEEDS]
            scores[source] = np.array(made, float)
        print(f"\n{hand}\n| tips | all | seeds | " + " | ".join(GROUPS) + " |")
        for name, each in scores.items():
            cells = [f"{100 * each[:, members].mean():.0f}" for members in groups]
            seeds = ", ".join(f"{100 * weighted(row[None], groups):.0f}" for row in each)
            print(f"| {name} | {100 * weighted(each, groups):.0f} | {seeds} | " + " | ".join(cells))
        pairs = [("evolved", "primitives"), ("evolved", "ycb"), ("primitives", "ycb")]
        for one, other in [*pairs, *((source, "as built") for source in SOURCES)]:
            found = difference(scores[one], scores[other], groups, f"{hand} {one} {other}")
            print(one, "-", other, "{:+.0f} ({:+.0f} to {:+.0f})".format(*(100 * np.array(found))))
            for name, members in zip(GROUPS, groups, strict=True):
                part = difference(scores[one], scores[other], [members], f"{hand} {one} {name}")
                print("   ", name, "{:+.0f} ({:+.0f} to {:+.0f})".format(*(100 * np.array(part))))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
