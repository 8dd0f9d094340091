"""How many failures a search finds with the same attempts, by where objects come from.

    python studies/failures/failures.py FOLDER --weights GGCNN2.pt --vgn VGN.pth [--detectors ...]
        [--strategies ...] [--seeds 5] [--attempts 2000] [--shards 1] [--least-difference 0.5]
        [--show] [--chart FILE.svg]

FOLDER keeps an atlas of each detector, strategy and seed (`egad.find_failures`); a second call
resumes where the first was interrupted. The script prints confirmed failures, and cells with one,
per 1000 attempts, with 95 % intervals over seeds (Student); for all seeds together, the failures,
how many of them are different objects, and the cells; the attempts that confirm a failure, and the
attempts at other objects per failure; and CPU minutes. `--show` prints the results so far.
README.md has the tables.
"""

import argparse
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import scipy.stats

import egad
from egad._util.arrays import Floats
from egad._util.files import write_text
from egad._util.markdown import table as markdown
from egad.bench.failures import FailureAtlas
from egad.bench.failures.atlas import CELL
from egad.bench.failures.parameters import Strategy
from egad.detectors import DetectorConfig
from egad.report.colors import line_color
from egad.report.drawing import new_figure

STRATEGIES: tuple[Strategy, ...] = ("random", "mutation", "screening", "evolution")
ALIKE = 0.8  # overlap of the voxels of two objects from which they count as the same object
HEAD = (
    *("strategy", "seeds", "failures", "cells", "all seeds", "different", "cells"),
    *("attempts at a failure", "elsewhere, per failure", "objects", "graspable", "CPU"),
)
SHIPPED = ("ggcnn2-evolved", "antipodal-depth", "antipodal-cloud")


def detectors(weights: Path | None, vgn: Path | None) -> dict[str, DetectorConfig]:
    """The detectors of the study by name."""
    known = {name: DetectorConfig(detector=name) for name in SHIPPED}
    if vgn is not None:
        known["vgn"] = DetectorConfig(detector="vgn", weights=str(vgn))
    if weights is None:
        return known
    given = {"detector": "ggcnn", "weights": str(weights)}
    return {
        "ggcnn2-published": DetectorConfig(**given, execution="published"),
        "ggcnn2": DetectorConfig(**given),
        **known,
    }


def search(
    folder: Path,
    config: DetectorConfig,
    strategy: Strategy,
    seed: int,
    attempts: int,
    shards: int,
    least_difference: float,
) -> None:
    """Run a search unless its result exists, on a core for each shard; keeps its CPU time, too."""
    done = folder / "cpu.txt"
    if done.exists():
        return
    start = sum(os.times()[:4])
    egad.find_failures(
        config,
        attempts=attempts,
        strategy=strategy,
        least_difference=least_difference,
        seed=seed,
        shards=shards,
        jobs=shards,
        out=folder,
    )
    done.write_text(f"{sum(os.times()[:4]) - start:.0f}\n", encoding="utf-8")


def row_of(folder: Path) -> dict[str, float]:
    """What a search has found."""
    atlas = FailureAtlas.load(folder)
    spent = int(atlas.examined["attempts"].sum())
    found = atlas.examined[atlas.examined["verdict"] == "failure"]
    cells = len(found[CELL].drop_duplicates())
    tried = atlas.examined[atlas.examined["attempts"] > 0]
    confirming = int(found["attempts"].sum())
    return {
        "failures": 1000 * len(found) / spent,
        "cells": 1000 * cells / spent,
        "confirming": confirming,
        "elsewhere": spent - confirming,
        "found": len(found),
        "objects": len(tried),
        "graspable": 1 - float((tried["verdict"] == "not_graspable").mean()),
        "cpu": float((folder / "cpu.txt").read_text()) / 60,
    }


def together(places: Sequence[Path]) -> tuple[int, int, int]:
    """Failures of all seeds, how many of these are different objects, and their cells."""
    examined = pd.concat([FailureAtlas.load(place).examined for place in places])
    found = examined[examined["verdict"] == "failure"]
    return len(found), len(unlike(found["voxels"])), len(found[CELL].drop_duplicates())


def unlike(objects: Iterable[bytes], others: Iterable[bytes] = ()) -> list[int]:
    """The indices of objects, given as voxels, that are unlike all earlier ones and all others."""
    known, found = list(others), []
    for number, voxels in enumerate(objects):
        if all(overlap(voxels, other) < ALIKE for other in known):
            known.append(voxels)
            found.append(number)
    return found


def overlap(one: bytes, other: bytes) -> float:
    """Intersection over union of the voxels of two objects."""
    first, second = (np.frombuffer(packed, np.uint8) for packed in (one, other))
    both, either = (np.bitwise_count(each).sum() for each in (first & second, first | second))
    return float(both / either)


def interval(values: pd.Series) -> str:
    """A mean with its 95 % interval, if there are several values."""
    mean = values.mean()
    if len(values) < 2:
        return f"{mean:.1f}"
    half = scipy.stats.t.ppf(0.975, len(values) - 1) * values.std() / np.sqrt(len(values))
    return f"{mean:.1f} ({mean - half:.1f} to {mean + half:.1f})"


def per_failure(rows: pd.DataFrame, what: str) -> str:
    """Attempts per failure, over all seeds."""
    failures = rows["found"].sum()
    return f"{rows[what].sum() / failures:.0f}" if failures else "-"


def show(folder: Path) -> None:
    """Print a table for each detector."""
    for place in sorted(path for path in folder.iterdir() if path.is_dir()):
        lines = []
        for strategy in STRATEGIES:
            done = sorted(place.glob(f"{strategy}-*/cpu.txt"))
            if not done:
                continue
            rows = pd.DataFrame([row_of(path.parent) for path in done])
            lines.append(
                (
                    *(strategy, len(rows), interval(rows["failures"]), interval(rows["cells"])),
                    *together([path.parent for path in done]),
                    *(per_failure(rows, name) for name in ("confirming", "elsewhere")),
                    f"{rows['objects'].mean():.0f}",
                    f"{100 * rows['graspable'].mean():.0f} %",
                    f"{rows['cpu'].mean():.0f} min",
                )
            )
        print(f"\n{place.name}\n\n{markdown(HEAD, lines)}", end="")


def found_by(folder: Path, steps: Floats) -> Floats:
    """Cells with a failure after these numbers of attempts of a search."""
    examined = FailureAtlas.load(folder).examined
    found = examined.assign(spent=examined["attempts"].cumsum())
    found = found[found["verdict"] == "failure"].drop_duplicates(CELL)
    return np.searchsorted(found["spent"], steps, side="right").astype(float)


def chart(folder: Path, attempts: int) -> str:
    """Cells with a failure over the attempts, the mean over seeds; SVG."""
    places = sorted(path for path in folder.iterdir() if path.is_dir())
    steps = np.linspace(0, attempts, 101)
    with new_figure(9.6, 3.2) as drawing:
        grid = np.atleast_1d(drawing.figure.subplots(1, len(places), sharey=True))
        for axes, place in zip(grid, places, strict=True):
            for number, strategy in enumerate(STRATEGIES):
                done = [path.parent for path in place.glob(f"{strategy}-*/cpu.txt")]
                found = [found_by(path, steps) for path in done]
                mean = np.mean(found, axis=0) if found else np.full(len(steps), np.nan)
                axes.plot(steps, mean, color=line_color(number), label=strategy)
            axes.set_title(place.name, size=10, loc="left")
            axes.set(xlabel="simulated grasps", xlim=(0, attempts))
            axes.grid(axis="y")
        grid[0].set_ylabel("cells with a failure")
        grid[0].set_ylim(0, None)
        grid[0].legend()
    return drawing.svg


def main() -> None:
    """Search, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--weights", type=Path, help="published weights of GG-CNN2")
    parser.add_argument("--vgn", type=Path, help="published weights of VGN")
    parser.add_argument("--detectors", nargs="+", help="some of those of the study")
    parser.add_argument("--strategies", nargs="+", default=STRATEGIES, choices=STRATEGIES)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--attempts", type=int, default=2000)
    parser.add_argument("--shards", type=int, default=1, help="of each search, a core each")
    parser.add_argument("--least-difference", type=float, default=0.5)
    parser.add_argument("--show", action="store_true", help="search no further")
    parser.add_argument("--chart", type=Path, help="SVG file to write")
    given = parser.parse_args()
    known = detectors(given.weights, given.vgn)
    for seed in range(0 if given.show else given.seeds):
        for name in given.detectors or known:
            for strategy in given.strategies:
                place = given.folder / name / f"{strategy}-{seed}"
                rest = (given.attempts, given.shards, given.least_difference)
                search(place, known[name], strategy, seed, *rest)
    show(given.folder)
    if given.chart:
        write_text(given.chart, chart(given.folder, given.attempts))


if __name__ == "__main__":
    main()
