"""The chart and the tables of docs/diversity.md: `python docs/diversity.py results.parquet`.

`python docs/diversity.py --luck` prints how often the luck of trainings looks like a better set.
"""

import sys
from pathlib import Path

import numpy as np

from egad.files import write_text
from egad.report.diversity_figures import success_chart
from egad.report.environment import p_value
from egad.seeds import generator
from egad.tables import parquet
from egad.tables.training import COMPARED
from egad.trials.comparison import sign_flip
from egad.trials.statistics import Rate
from egad.trials.training_sets import Tried, by_set, by_test, set_pairs

HERE = Path(__file__).parent
OBJECTS, ATTEMPTS, REPEATS = 48, 20, 4000
SHIFTS, SPREADS = (0.0, 0.03, 0.06), (0.0, 0.1)


def main(path: Path) -> None:
    """Write the chart beside this file and print the tables."""
    tests = by_test(parquet.read(path, COMPARED))
    write_text(HERE / "diversity.svg", success_chart(tests))
    for name, tried in tests.items():
        tell(name, tried)
        compare(tried)


def tell(test: str, tried: Tried) -> None:
    """Print the success of all sets in a test."""
    print(f"\n| success on {test}, % | all networks | each |\n| --- | --- | --- |")
    for name, found in tried.sets.items():
        each = ", ".join(f"{100 * one.value:.0f}" for one in found.each.values())
        print(f"| `{name}` | {text(found.pooled)} | {each} |")
    for name, rate in tried.references.items():
        print(f"| {name} | {text(rate)} | |")


def compare(tried: Tried) -> None:
    """Print every pair of sets."""
    print("\n| pair | points | each | began alike | p | p, Holm |\n" + "| --- " * 6 + "|")
    for pair in set_pairs(by_set(tried.rows)):
        low, high = (100 * end for end in pair.result.interval)
        points = f"{100 * pair.result.difference:.0f} ({low:.0f} to {high:.0f})"
        each = ", ".join(f"{100 * gain:.0f}" for gain in pair.each)
        alike = f"{pair.result.alike} of {pair.result.attempts}"
        numbers = f"{each} | {alike} | {p_value(pair.result.p_objects)} | {p_value(pair.p_holm)}"
        print(f"| `{pair.first}` against `{pair.second}` | {points} | {numbers} |")


def text(rate: Rate) -> str:
    """A rate with its interval, percent."""
    low, high = (100 * end for end in rate.interval)
    return f"{100 * rate.value:.0f} ({low:.0f} to {high:.0f})"


def luck() -> None:
    """Print how often p is below 0.05 for sets that are equally good to learn from."""
    print("| cases of p < 0.05, % | " + " | ".join(f"{100 * each:.0f}" for each in SHIFTS) + " |")
    print("| --- " * (len(SHIFTS) + 1) + "|")
    for spread in SPREADS:
        found = [f"{100 * by_luck(shift, spread):.0f}" for shift in SHIFTS]
        print(f"| objects apart by {100 * spread:.0f} | {' | '.join(found)} |")


def by_luck(shift: float, spread: float) -> float:
    """How often two networks are found better than two others by nothing but their trainings.

    An object is grasped with a probability of its own, Beta(2, 2). Each training shifts that of all
    objects by one normal number, and of each object by one more. Attempts are independent.

    Args:
        shift: Standard deviation of the first.
        spread: Standard deviation of the second.
    """
    random = generator(0, "luck", round(1000 * shift), round(1000 * spread))
    easy = random.beta(2, 2, size=(REPEATS, 1, 1, OBJECTS))
    all_alike = random.normal(0, shift, (REPEATS, 2, 2, 1))  # two sets of two networks
    own = random.normal(0, spread, (REPEATS, 2, 2, OBJECTS))
    won = random.binomial(ATTEMPTS, np.clip(easy + all_alike + own, 0, 1)).sum(axis=2)
    return float(np.mean([sign_flip(gains) < 0.05 for gains in won[:, 0] - won[:, 1]]))


if __name__ == "__main__":
    luck() if sys.argv[1] == "--luck" else main(Path(sys.argv[1]))
