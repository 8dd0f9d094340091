"""How often the check refuses honest cleared tables, and finds forged ones.

    python studies/verification/cleared.py antipodal-cloud --honest 10 --forged 100

The tables of the leaderboard are cleared again with nudged objects, as other processors might make
them. In a forged one, failures are said to be successes.
"""

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from checks import SHARES, line

from egad._util.arrays import Ints
from egad.bench import (
    ClutterParameters,
    Reproduction,
    groups_of,
    nudged,
    repeat_round,
)
from egad.bench.reproduction import NUDGES
from egad.bench.verification import judge_round
from egad.exchange import evaluation_set_models
from egad.random import generator
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, ROUND
from egad_workflow.leaderboard import read_protocol
from egad_workflow.settings import select

PROTOCOL = "clutter-mujoco"


class Table:
    """A cleared table, again with nudged objects."""

    def __init__(self, path: Path, rounds: int | None) -> None:
        """Clear all rounds again, once for each nudge of the check."""
        _, settings = read_protocol(Path(f"leaderboard/protocols/{PROTOCOL}.yaml"))
        name = settings.targets.grippers[0]
        self.settings = select(settings, ClutterParameters, name)
        gripper = settings.grippers[name]
        self.models = evaluation_set_models(gripper, settings.rescale.rule)
        known = groups_of(parquet.read(path, CLUTTER), rounds, 0)
        self.rounds = {tuple(rows[ROUND].iloc[0]): rows.reset_index(drop=True) for rows in known}
        self.again = {
            by: {key: self.cleared(rows, by) for key, rows in self.rounds.items()}
            for by in (0.0, *NUDGES)
        }

    def cleared(self, rows: pd.DataFrame, by: float) -> pd.DataFrame:
        """A round with the same grasps, the inertia of the objects changed by a fraction."""
        names = rows["objects"].iloc[0].split()
        objects = {name: nudged(self.models[name], by) for name in names}
        return repeat_round(rows, objects, self.settings)

    def nudged_round(self, key: tuple[Any, ...], by: float, rows: Ints) -> pd.DataFrame:
        """What was cleared again."""
        return self.again[by][key].reindex(rows)

    def verdict(self, said: dict[tuple[Any, ...], pd.DataFrame]) -> Reproduction:
        """What the check says of a table."""
        parts = (
            judge_round(
                rows, partial(self.nudged_round, key), [f"{key}, {at}" for at in range(len(rows))]
            )
            for key, rows in said.items()
        )
        return sum(parts, start=Reproduction())

    def honest(self, count: int) -> Iterator[dict[tuple[Any, ...], pd.DataFrame]]:
        """Tables as other processors might make them."""
        for number in range(count):
            by = -1e-13 * (number + 0.5)
            yield {key: self.cleared(rows, by) for key, rows in self.rounds.items()}


def turned(
    honest: dict[tuple[Any, ...], pd.DataFrame], share: float, rng: np.random.Generator
) -> dict[tuple[Any, ...], pd.DataFrame]:
    """The table with failures said to be successes, at most one in a round."""
    said = {key: rows.copy() for key, rows in honest.items()}
    failed = {
        key: np.flatnonzero(~rows["success"] & rows["width"].notna()) for key, rows in said.items()
    }
    keys = [key for key, rows in failed.items() if len(rows)]
    count = min(max(round(share * sum(map(len, said.values()))), 1), len(keys))
    for each in rng.choice(len(keys), count, replace=False):
        row = rng.choice(failed[keys[each]])
        said[keys[each]].loc[row, ["success", "outcome"]] = True, "success"
    return said


def main() -> None:
    """Print the rows of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("entries", nargs="+")
    parser.add_argument("--honest", type=int, default=10)
    parser.add_argument("--forged", type=int, default=100)
    parser.add_argument("--rounds", type=int)
    given = parser.parse_args()
    for entry in given.entries:
        table = Table(Path(f"leaderboard/entries/{entry}/{PROTOCOL}.parquet"), given.rounds)
        print(f"\n{entry}: {len(table.rounds)} rounds", flush=True)
        shipped = table.verdict(table.rounds)
        print(shipped, flush=True)
        honest = list(table.honest(given.honest))
        verdicts = [table.verdict(each) for each in honest]
        print(sum(verdicts, start=Reproduction()), flush=True)
        refused = sum(not each.is_honest for each in verdicts)
        print(line("honest", refused, given.honest), flush=True)
        for share in SHARES:
            rng = generator(0, "forged", entry, str(share))
            forged = [
                table.verdict(turned(honest[rng.integers(len(honest))], share, rng))
                for _ in range(given.forged)
            ]
            refused = sum(not each.is_honest for each in forged)
            print(line(f"{share:.0%} turned", refused, given.forged), flush=True)


if __name__ == "__main__":
    main()
