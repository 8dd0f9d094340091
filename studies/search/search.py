"""The curves of README.md: `search.py NAME=history.parquet ...`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.files import write_text
from egad.measures import MeasureSpace
from egad.report.evolution import coverage_curves, coverage_history
from egad.tables import parquet
from egad.tables.evolution import HISTORY

FOLDER = Path(__file__).parent
DRAWN = 20_000  # evaluations: all of a long run would leave no room for the others
ELITES = MeasureSpace().elites_per_cell
SHOWN = (2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000)


def main(runs: dict[str, Path]) -> None:
    """Write the figure beside this file and print the table."""
    histories = {name: parquet.read(path, HISTORY) for name, path in runs.items()}
    starts = {
        name: history[history["offspring"].cumsum() <= DRAWN] for name, history in histories.items()
    }
    write_text(FOLDER / "search.svg", coverage_curves(starts))
    print("| evaluations | " + " | ".join(histories) + " |")
    print("| --- " * (len(histories) + 1) + "|")
    steps = {name: coverage_history(history) for name, history in histories.items()}
    for count in SHOWN:
        row = [after(each, count) for each in steps.values()]
        if any(row):
            print(f"| {count:,} | " + " | ".join(row) + " |")
    reach({name: each["cells"] for name, each in steps.items()})


def reach(cells: dict[str, pd.Series]) -> None:
    """Print the share that each run fills of the cells that any run has reached."""
    most = {
        name: np.stack([np.frombuffer(each, np.uint8) for each in cells[name]]) for name in cells
    }
    ever = np.any([counts.any(axis=0) for counts in most.values()], axis=0)
    print(f"\ncells that a run has reached: {ever.sum()} of {len(ever)}")
    for name, counts in most.items():
        elites = counts[-1].sum() / ELITES
        print(f"{name}: {elites / ever.sum():.3f} of their slots, {elites / len(ever):.3f} of all")


def after(steps: pd.DataFrame, count: int) -> str:
    """Coverage, filled cells and QD-score after some evaluations; empty if there were fewer."""
    if steps["offspring"].iloc[-1] < count:
        return ""
    so_far = steps[steps["offspring"] <= count]
    scores = so_far["qd_score"].dropna()
    last = so_far.iloc[-1]
    score = f"{scores.iloc[-1]:.0f}" if len(scores) else "-"
    return f"{last['coverage']:.3f} {last['filled_cells']:.3f} {score}"


if __name__ == "__main__":
    main({name: Path(path) for name, _, path in (each.partition("=") for each in sys.argv[1:])})
