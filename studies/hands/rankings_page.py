"""The tables of README.md, from what `rankings.py` kept: `python rankings_page.py OUT`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from egad.bench.hands import HandComparison
from egad.random import generator
from egad.tables.hands import GRASPERS

ENGINES = {"mujoco": "MuJoCo", "pybullet": "PyBullet"}


def card_of(out: Path, engine: str, seed: int = 0) -> HandComparison:
    """One comparison of all the hands that were compared alone."""
    parts = [HandComparison.load(path) for path in sorted((out / engine / str(seed)).glob("*"))]
    hands = {name: hand for part in parts for name, hand in part.hands.items()}
    detectors = {name: each for part in parts for name, each in part.detectors.items()}
    table = pd.concat([part.table for part in parts])
    return HandComparison(table, hands, detectors, parts[0].settings, parts[0].rule)


def agreement(first: HandComparison, second: HandComparison, who: str) -> str:
    """Rank correlation of the rates of the hands that both have; interval over objects."""
    names = [name for name in first.hands if name in second.hands]
    tables = []
    for card in (first, second):
        rows = [card.attempts(name, who).groupby("label")["success"].mean() for name in names]
        tables.append(pd.concat(rows, axis=1, keys=names))
    one, two = (each.to_numpy(float) for each in tables)
    rng = generator(0, "hands", "bootstrap", who)
    draws = rng.integers(len(one), size=(2000, len(one)))
    found = [spearmanr(one[rows].mean(axis=0), two[rows].mean(axis=0))[0] for rows in draws]
    low, high = np.nanpercentile(found, [2.5, 97.5])
    whole = spearmanr(one.mean(axis=0), two.mean(axis=0))[0]
    return f"{whole:.2f} ({low:.2f} to {high:.2f})"


def main(out: Path) -> None:
    """Print success and ranks of each hand, and how well the engines agree."""
    cards = {engine: card_of(out, engine) for engine in ENGINES if (out / engine).is_dir()}
    ranks = {engine: card.ranks() for engine, card in cards.items()}
    rates = {e: {who: card.rates(who) for who in GRASPERS} for e, card in cards.items()}
    first = next(iter(cards))
    heads = [f"{ENGINES[e]}: best | rank | detector | naive" for e in cards]
    print("| hand | opens, mm | " + " | ".join(heads) + " |")
    print("| --- " * (2 + 4 * len(cards)) + "|")
    for name in sorted(cards[first].hands, key=lambda each: -rates[first]["best"][each].value):
        cells = [name, f"{1000 * cards[first].hands[name].opening:.1f}"]
        for engine, found in rates.items():
            if name not in found["best"]:
                cells += [""] * 4
                continue
            low, high = found["best"][name].interval
            cells.append(
                f"{100 * found['best'][name].value:.0f} ({100 * low:.0f} to {100 * high:.0f})"
            )
            cells.append(f"{ranks[engine][name].best} to {ranks[engine][name].worst}")
            cells += [f"{100 * found[who][name].value:.0f}" for who in ("detector", "naive")]
        print("| " + " | ".join(cells) + " |")
    if len(cards) == 2:
        for who in GRASPERS:
            print(who, agreement(*cards.values(), who))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
