"""The tables of README.md and the picture of docs/trials.md.

Run `python studies/engines/trials.py results/D G P...`. The table has success in percent with 95 %
intervals for other objects, and the rank correlations of success with difficulty and complexity.
For each outcome that came to a grasp, the first attempt of these detectors with that outcome is
repeated; a row shows frames of it, evenly spaced from when the hand comes to when it leaves.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from egad.bench import SimulatedTrials, repeat_attempt
from egad.bench.stats import object_positions, trend, trial_grid
from egad.exchange import bundle_models
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.outcomes import EXECUTION, Outcome
from egad_workflow.settings import Settings, select

sys.path.append(str(Path(__file__).parents[1]))
from pictures import chosen, save_sheet

DOCS = Path(__file__).parents[2] / "docs"
FRAMES = 6
LOST = [each for each in EXECUTION if each not in (Outcome.SUCCESS, Outcome.COLLIDED)]


def main(folder: Path, gripper: str, *detectors: str) -> None:
    """Print the table and write the picture."""
    tables = {
        name: parquet.read(folder / "trials" / gripper / f"{name}.parquet", TRIALS)
        for name in detectors
    }
    chosen_set = parquet.read(folder / "eval49.parquet", EVAL49)
    names = ("all", "row A", "row G", "collided", "no grasp", "lost", "difficulty", "complexity")
    print(f"| | {' | '.join(names)} |\n{'| --- ' * (len(names) + 1)}|")
    for name, trials in tables.items():
        print(f"| `{name}` | {' | '.join(figures(trials, chosen_set))} |")
    draw(folder / "bundle" / gripper, gripper, pd.concat(tables.values()))


def figures(trials: pd.DataFrame, chosen_set: pd.DataFrame) -> Iterator[str]:
    """Success of all objects, row A and row G; failures by kind; correlations."""
    grid = trial_grid(trials, *(chosen_set[axis].max() + 1 for axis in ("row", "column")))
    for mean in (grid.overall, grid.rows[0], grid.rows[-1]):
        yield between(100 * mean.value, *(100 * end for end in mean.interval), digits=0)
    for outcomes in ([Outcome.COLLIDED], [Outcome.NO_GRASP], LOST):
        yield str(trials["outcome"].isin(outcomes).sum())
    positions = object_positions(trials, chosen_set)
    for name in ("difficulty", "complexity"):
        found = trend(positions[name].to_numpy(), positions["rate"].to_numpy())
        yield between(found.rho, found.ci_low, found.ci_high, digits=2)


def between(value: float, low: float, high: float, digits: int) -> str:
    """A value and its interval."""
    return f"{value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def draw(bundle: Path, gripper: str, trials: pd.DataFrame) -> None:
    """Frames of the first attempt with each outcome."""
    settings = select(Settings(), SimulatedTrials, gripper)
    shown = [trials[trials["outcome"] == outcome].head(1) for outcome in EXECUTION]
    models = bundle_models(bundle)
    rows = []
    for row in parquet.records(pd.concat(shown)):
        _, frames = repeat_attempt(settings, row, models)
        title = f"{row['outcome']}: {row['label']}, attempt {row['attempt']}"
        rows.append((title, chosen(frames, FRAMES)))
    save_sheet(rows, DOCS / "trials.png", colors=64)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
