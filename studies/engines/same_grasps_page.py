"""The tables of same_grasps.md: `python studies/engines/same_grasps_page.py FOLDER ...`.

The folders are those of `same_grasps.py`. Intervals are at 95 %, by bootstrap over objects.
"""

import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd

from egad.random import generator
from egad.sim import ENGINES

RESAMPLES = 10_000
NAMES = {"mujoco": "MuJoCo", "pybullet": "PyBullet", "drake": "Drake"}


def read(folders: list[Path]) -> pd.DataFrame:
    """Whether each grasp (rows: object and grasp) succeeds in each variant with each errors."""
    files = [path for folder in folders for path in sorted(folder.glob("[A-G][0-6].csv"))]
    rows = pd.concat([pd.read_csv(path) for path in files]).drop_duplicates(
        ["label", "grasp", "variant", "errors"]
    )
    rows["success"] = rows["outcome"] == "success"
    return rows.pivot(index=["label", "grasp"], columns=["errors", "variant"], values="success")


def share(values: pd.Series) -> str:
    """Mean of a column in per cent, with its interval over objects."""
    known = values.dropna().astype(float)
    groups = known.groupby(level="label").agg(["sum", "size"]).to_numpy()
    rng = generator(0, "engines", "bootstrap")
    drawn = groups[rng.integers(len(groups), size=(RESAMPLES, len(groups)))].sum(axis=1)
    low, high = 100 * np.percentile(drawn[:, 0] / drawn[:, 1], [2.5, 97.5])
    return f"{100 * known.mean():.1f} ({low:.1f} to {high:.1f})"


def engines_table(table: pd.DataFrame) -> None:
    """Success by engine; difference and parted grasps by pair."""
    for errors in ("none", "typical"):
        found = table[errors][list(ENGINES)].dropna().astype(float)
        print(f"errors {errors}: {len(found)} grasps, {found.index.unique('label').size} objects")
        for engine in ENGINES:
            print(f"  {NAMES[engine]}: {share(found[engine])}")
        print(found.astype(int).value_counts().to_string())
        for first, second in combinations(ENGINES, 2):
            parted = share(found[first] != found[second])
            gap = share(found[first] - found[second])
            print(f"  {NAMES[first]} - {NAMES[second]}: parted {parted}, difference {gap}")


def switches_table(table: pd.DataFrame) -> None:
    """For each switch: what it changes in its engine, and how far that engine is from another.

    Parted grasps are those of the two engines without a switch; `joined` is the part of them that
    the switch brings together.
    """
    known = table["typical"]
    for variant in known.columns:
        engine, _, name = variant.partition(": ")
        for other in ENGINES if name else ():
            if other == engine:
                continue
            rows = known[[variant, engine, other]].dropna().astype(float)
            parted = rows[rows[engine] != rows[other]]
            joined = (parted[variant] == parted[other]).sum()
            print(
                f"{NAMES[engine]}, {name}, against {NAMES[other]}: {len(rows)} grasps; "
                f"success {share(rows[variant])}; changed {share(rows[variant] != rows[engine])}; "
                f"joined {joined} of {len(parted)}; parted {share(rows[variant] != rows[other])}; "
                f"difference {share(rows[variant] - rows[other])}"
            )


def main(folders: list[Path]) -> None:
    """Print the tables."""
    table = read(folders)
    engines_table(table)
    switches_table(table)


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
