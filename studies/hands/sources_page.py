"""The tables of the README, from what `sources.py` kept: `python sources_page.py OUT`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t
from sources import ENGINES, SEEDS, SOURCES

from egad.bench.hands import HandComparison
from egad.random import generator

COUNTED = ["best", "detector"]  # graspers
DRAWS = 2000
GROUPS = ("evolved", "primitives", "ycb", "household")
Scores = NDArray[np.float64]  # (designs, objects)


def judged(out: Path, hand: str) -> tuple[list[str], list[int]]:
    """The engines in which a hand was judged as built, and seeds with all sources in these."""
    engines = [each for each in ENGINES if (out / hand / each / "evolved-0.parquet").exists()]
    seeds = [
        seed
        for seed in SEEDS
        if all(
            (out / hand / engine / f"{source}-{seed}.parquet").exists()
            for engine in engines
            for source in SOURCES
        )
    ]
    return engines, seeds


def scores_of(out: Path, hand: str, engines: list[str], which: str) -> pd.Series:
    """Score of a hand at each object: mean of graspers, engines and drops."""
    parts = [
        HandComparison.load(out / hand / engine / f"{which}.parquet").table for engine in engines
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
    one: Scores, other: Scores, groups: list[NDArray[np.int64]], purpose: str, level: float = 0.95
) -> tuple[float, float, float]:
    """Mean difference, and its interval: t with variances over seeds and over objects.

    That over objects is by bootstrap within groups; degrees of freedom are those of Welch.
    """
    rng = generator(0, "sources of tips", purpose)
    mean = one.mean(axis=0) - other.mean(axis=0)
    drawn = [[rng.choice(members, len(members)) for members in groups] for _ in range(DRAWS)]
    parts = [(np.var([weighted(mean[None], each) for each in drawn]), mean.size - 1)]
    for scores in (one, other):
        if len(scores) > 1:
            seeds = [weighted(row[None], groups) for row in scores]
            parts.append((np.var(seeds, ddof=1) / len(seeds), len(seeds) - 1))
    variance = sum(part for part, _ in parts)
    freedom = variance**2 / sum(part**2 / free for part, free in parts) if variance else 1.0
    half = float(t.ppf((1 + level) / 2, freedom) * np.sqrt(variance))
    found = weighted(mean[None], groups)
    return found, found - half, found + half


def main(out: Path) -> None:
    """Print the scores by group of objects, and the differences."""
    for hand in sorted(path.name for path in out.iterdir() if path.is_dir()):
        engines, seeds = judged(out, hand)
        built = scores_of(out, hand, engines, "as-built")
        labels = list(built.index)
        groups = [np.flatnonzero([group_of(e) == g for e in labels]) for g in GROUPS]
        scores = {"as built": built.to_numpy(float)[None]}
        for source in SOURCES:
            made = [scores_of(out, hand, engines, f"{source}-{seed}")[labels] for seed in seeds]
            scores[source] = np.array(made, float)
        print(
            f"\n{hand}, {', '.join(engines)}\n| tips | all | seeds | " + " | ".join(GROUPS) + " |"
        )
        for name, each in scores.items():
            cells = [f"{100 * each[:, members].mean():.0f}" for members in groups]
            each_seed = ", ".join(f"{100 * weighted(row[None], groups):.0f}" for row in each)
            print(
                f"| {name} | {100 * weighted(each, groups):.0f} | {each_seed} | "
                + " | ".join(cells)
            )
        pairs = [("evolved", "primitives"), ("evolved", "ycb"), ("primitives", "ycb")]
        for one, other in [*pairs, *((source, "as built") for source in SOURCES)]:
            found = difference(scores[one], scores[other], groups, f"{hand} {one} {other}")
            print(one, "-", other, "{:+.0f} ({:+.0f} to {:+.0f})".format(*(100 * np.array(found))))
            wider = difference(scores[one], scores[other], groups, f"{hand} {one} {other}", 0.9875)
            print("    at 98.75 %:", "{:+.0f} to {:+.0f}".format(*(100 * np.array(wider[1:]))))
            for name, members in zip(GROUPS, groups, strict=True):
                part = difference(scores[one], scores[other], [members], f"{hand} {one} {name}")
                print("   ", name, "{:+.0f} ({:+.0f} to {:+.0f})".format(*(100 * np.array(part))))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
