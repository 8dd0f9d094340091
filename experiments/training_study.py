"""Figure and tables of docs/training.md: `python experiments/training_study.py RESULTS`.

RESULTS is the folder `results/training_study` of the study, or of a part of it. The outcomes of its
attempts go into docs/training.parquet, and the figure and the tables are of all attempts there.
"""

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.files import write_text
from egad.pipeline.cli.common import settings_in
from egad.pipeline.report.training_study import panels, rates_by_test
from egad.report.page import p_value
from egad.report.training_study import Row, success_chart
from egad.report.trial_charts import OUTCOMES, outcome_counts
from egad.stats import Spread, check_starts, compare_sets, pooled_spread, set_or_detector
from egad.tables import parquet
from egad.tables.training import CLEARED, COMPARED

ROOT = Path(__file__).parents[1]
CONFIG = ROOT / "config/training_study.yaml"
NETWORK = ["test", "noise", "training_set", "seed", "detector"]  # and in what it was tested
COLUMNS = [*NETWORK, "label", "attempt", "initial_pose", "success", "outcome"]
Floats = NDArray[np.float64]


def main(results: Path, comparisons: Iterable[tuple[str, str]], docs: Path = ROOT / "docs") -> None:
    """Write the figure into docs and print the tables."""
    made = parquet.read(results / "results.parquet", COMPARED)
    trials = update_attempts(made[COLUMNS], docs / "training.parquet")
    rates = rates_by_test(trials, parquet.read(results / "clutter.parquet", CLEARED))
    shown = panels(rates, set(trials["training_set"]) - {""})
    write_text(docs / "training.svg", success_chart(shown))
    print_success(shown)
    print_comparisons(trials, comparisons)
    for key, found in rates.items():
        print_spread(", ".join(key), found)
    print_outcomes(trials)


def update_attempts(made: pd.DataFrame, path: Path) -> pd.DataFrame:
    """Write the attempts of a run into the table of all attempts, and return it.

    Args:
        made: Columns `COLUMNS`. Its networks and detectors replace those of the same names.
        path: The table.

    Raises:
        UserError: Attempts that should start with the same drop do not.
    """
    if path.is_file():
        earlier = pd.read_parquet(path)
        known = pd.MultiIndex.from_frame(earlier[NETWORK])
        stays = ~known.isin(pd.MultiIndex.from_frame(made[NETWORK]))
        made = pd.concat([earlier[stays], made], ignore_index=True)
    for _, rows in made.groupby("test"):
        check_starts(rows)
    made.to_parquet(path, compression="zstd", index=False)
    return made


def print_success(shown: Mapping[str, Mapping[str, Row]]) -> None:
    """Success with single objects: means with intervals over networks, percent."""
    print(
        f"\n| trained on | networks | {' | '.join(shown)} |\n" + "| --- " * (len(shown) + 2) + "|"
    )
    for name, first in next(iter(shown.values())).items():
        cells = [text(rows[name]) for rows in shown.values()]
        print(f"| `{name}` | {len(first.values) if first.trained else ''} | {' | '.join(cells)} |")


def text(row: Row) -> str:
    """A mean with its interval, percent."""
    low, high = row.interval
    between = "" if np.isnan(low) else f" ({100 * low:.0f} to {100 * high:.0f})"
    return f"{100 * row.mean:.0f}{between}"


def print_comparisons(trials: pd.DataFrame, comparisons: Iterable[tuple[str, str]]) -> None:
    """The pre-registered comparisons, points; none before both sides of all were tested."""
    tested = set(set_or_detector(trials))
    comparisons = list(comparisons)
    if not tested.issuperset(name for pair in comparisons for name in pair):
        return
    print("\n| pair | test | over networks | p | p, Holm | over objects |\n" + "| --- " * 6 + "|")
    for row in compare_sets(trials, comparisons):
        gain = row.difference.gain
        cells = [
            f"{row.test}, {row.noise}",
            f"{100 * gain:.1f} ({points(row.difference.interval)})",
        ]
        cells += [p_value(row.difference.p), p_value(row.p_holm), points(row.by_objects)]
        print(f"| `{row.first}` - `{row.second}` | {' | '.join(cells)} |")


def points(interval: tuple[float, float]) -> str:
    """An interval of differences or standard deviations, points."""
    return " to ".join(f"{100 * end:.1f}" for end in interval)


def print_spread(title: str, rates: Mapping[str, Floats]) -> None:
    """Standard deviations between the networks of each set, and of all sets together, points."""
    each = {name: pooled_spread([values]) for name, values in rates.items()}
    shown = {f"`{name}`": found for name, found in each.items() if found}
    print(f"\n| networks on {title} | standard deviation |\n| --- | --- |")
    for name, found in [*shown.items(), ("all", pooled_spread(rates.values()))]:
        print(f"| {name} | {deviation(found)} |")


def deviation(spread: Spread | None) -> str:
    """A standard deviation with its interval, points."""
    return f"{100 * spread.sd:.1f} ({points(spread.interval)})" if spread else ""


def print_outcomes(trials: pd.DataFrame) -> None:
    """How attempts at single objects ended, percent."""
    names = trials["training_set"].where(trials["training_set"] != "", trials["detector"])
    for (test, noise), rows in trials.groupby(["test", "noise"], sort=False):
        own = rows.groupby(names[rows.index], sort=False)
        counts = {name: outcome_counts(each) for name, each in own}
        kinds = [kind for kind in OUTCOMES if any(kind in found for found in counts.values())]
        heads = " | ".join(kind.replace("_", " ") for kind in kinds)
        print(f"\n| attempts on {test}, {noise} | {heads} |\n" + "| --- " * (len(kinds) + 1) + "|")
        for name, found in counts.items():
            parts = (f"{100 * found.get(kind, 0) / sum(found.values()):.1f}" for kind in kinds)
            print(f"| `{name}` | {' | '.join(parts)} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), settings_in(CONFIG).training_study.comparisons)
