"""The table of docs/training-study.md on seed variance: how often it looks like a better set."""

import numpy as np

from egad.random import generator
from egad.stats import sign_flip

OBJECTS, ATTEMPTS, REPEATS = 48, 20, 4000
SHIFTS, SPREADS = (0.0, 0.04, 0.1), (0.0, 0.1)


def main() -> None:
    """Print how often p is below 0.05 for sets that are equally good to learn from."""
    print("| cases of p < 0.05, % | " + " | ".join(f"{100 * each:.0f}" for each in SHIFTS) + " |")
    print("| --- " * (len(SHIFTS) + 1) + "|")
    for spread in SPREADS:
        found = [f"{100 * by_luck(shift, spread):.0f}" for shift in SHIFTS]
        print(f"| each object by {100 * spread:.0f} more | {' | '.join(found)} |")


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
    main()
