"""Whether objects that are hard for jaws are hard for suction cups.

    python studies/grippers/cup_rankings.py TABLE.parquet [--jobs 2]

The graspability of all released objects is measured for a Panda and for cups of 15 and 30 mm, at
the same size, from 512 candidates each. TABLE.parquet keeps them; a second call measures what is
missing. The script prints rank correlations (Spearman, with 95 % intervals over objects), how many
objects have no grasp or a graspability of 0, and which are easy for jaws and hard for the cup, or
the reverse. The second row repeats the first hand with other grasps.
"""

import argparse
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

import egad
from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad._util.workers import workers
from egad.random import generator

HANDS = {"panda": ("panda", 0), "panda, again": ("panda", 1)} | {
    cup: (cup, 0) for cup in ("cup_15mm", "cup_30mm")
}
CANDIDATES, DRAWS = 512, 2000
BATCH = 50  # objects


def graspabilities(label: str, objects: egad.Dataset) -> dict[str, float | str]:
    """Label and graspability of an object for each hand; NaN if it has no grasp."""
    target = objects[label]
    row: dict[str, float | str] = {"label": target.label}
    for name, (hand, seed) in HANDS.items():
        try:
            found = egad.measure(target.mesh, hand, max_candidates=CANDIDATES, seed=seed)
            row |= {name: found.graspability, "complexity": found.complexity}
        except egad.RejectedError:
            row[name] = np.nan
    return row


def measured(path: Path, jobs: int) -> pd.DataFrame:
    """The table, after measuring and adding the objects that it lacks."""
    warnings.simplefilter("ignore")
    objects = egad.load("released")
    table = pd.read_parquet(path) if path.is_file() else pd.DataFrame({"label": []})
    known = set(table["label"])
    left = [each.label for each in objects if each.label not in known]
    with workers(jobs) as mapper:
        for start in range(0, len(left), BATCH):
            found = mapper(partial(graspabilities, objects=objects), left[start : start + BATCH])
            table = pd.concat([table, pd.DataFrame(list(found))], ignore_index=True)
            with atomic_output(path) as out:
                table.to_parquet(out)
            print(len(table), "of", len(objects), flush=True)
    return table


def correlation(first: Floats, second: Floats) -> str:
    """Spearman's rank correlation with its interval."""
    both = np.stack([first, second])
    rng = generator(0, "cup-rankings")
    drawn = [
        spearman(*both[:, rng.integers(0, both.shape[1], both.shape[1])]) for _ in range(DRAWS)
    ]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return f"{spearman(*both):.2f} ({low:.2f} to {high:.2f})"


def spearman(first: Floats, second: Floats) -> float:
    """Spearman's rank correlation."""
    ranks = pd.DataFrame({"first": first, "second": second}).rank().to_numpy()
    return float(np.corrcoef(ranks.T)[0, 1])


def show(table: pd.DataFrame) -> None:
    """Print what is in the table."""
    values = table[list(HANDS)].fillna(0.0)
    print(f"{len(table)} objects\n\n| | {' | '.join(HANDS)} |\n|{' --- |' * (len(HANDS) + 1)}")
    for name in HANDS:
        cells = [
            "" if name == other else correlation(values[name].to_numpy(), values[other].to_numpy())
            for other in HANDS
        ]
        print(f"| `{name}` | {' | '.join(cells)} |", flush=True)
    print("\nno grasp:", table[list(HANDS)].isna().sum().to_dict())
    print("graspability 0:", (values == 0).sum().to_dict())
    ranks = values.rank(pct=True)
    apart = (ranks["cup_30mm"] - ranks["panda"]).sort_values()
    print("easy for jaws, hard for the cup:", *table["label"][apart.index[:8]])
    print("hard for jaws, easy for the cup:", *table["label"][apart.index[::-1][:8]])
    by_complexity = table.assign(part=pd.qcut(table["complexity"], 4, labels=False))
    print(by_complexity.groupby("part")[list(HANDS)].median().round(4).to_markdown())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    show(measured(given.table, given.jobs))
