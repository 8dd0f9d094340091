"""A comparison of searches under noise: how they cope with estimates of graspability.

    python studies/search/noisy_search.py METHOD SEED   # one run, to noisy-search/
    python studies/search/noisy_search.py               # figure and table of all runs so far

A run is 20,000 evaluations in steps of 100 on one core. Every offspring counts as an evaluation,
empty and known ones too, and so does every further evaluation of an elite. The refinement of
`sequential` counts only as CPU time. All methods sample parents near empty slots.

- `paper`: each offspring is measured once, by 100 spaced grasps.
- `adaptive`: re-evaluated when challenged (Justesen et al. 2019). Before an offspring takes the
  slot of an elite, both are evaluated once more.
- `depth`: in the style of Extract-QD (Flageat et al. 2025). Cells are twice as deep, and a quarter
  of the evaluations re-evaluate elites, those evaluated least often first.
- `sequential`: as shipped.

An evaluation of `adaptive` and `depth` is a first estimate of `sequential`; the mean of all
evaluations of an object places it. Corrected values place the elites by an independent estimate of
certainty.py.
"""

import sys
import time
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from certainty import independent

from egad._util.files import write_text
from egad.evolution import Archive, Elite, EvolutionParameters, packed_surface
from egad.evolution.evaluation import measure
from egad.evolution.island import Island
from egad.measures import MeasureSpace, rough_graspability
from egad.random import generator
from egad.report.colors import line_color
from egad.report.drawing import new_figure, show_percent
from egad_workflow.precompile import compile_kernels
from egad_workflow.settings import Settings, select

FOLDER = Path(__file__).parent
ROWS = FOLDER / "noisy-search"
METHODS = ("paper", "adaptive", "depth", "sequential")
EVALUATIONS, STEP, SNAPSHOT, SHARE = 20_000, 100, 5_000, 0.25
SPACE = MeasureSpace()


def settings_of(method: str, seed: int) -> EvolutionParameters:
    """Settings of the search; only `sequential` tells certain from uncertain elites."""
    changes: dict[str, Any] = {"seed": seed, "evolution": {"population": STEP}}
    if method == "paper":
        changes["evolution"]["estimator"] = "paper"
    if method == "depth":
        changes["space"] = {"elites_per_cell": 2 * SPACE.elites_per_cell}
        changes["evolution"]["population"] = round((1 - SHARE) * STEP)
    return select(Settings.model_validate(changes), EvolutionParameters)


class Repeated(Archive):
    """An archive whose objects can be evaluated again; the mean of all evaluations counts."""

    def __init__(self, settings: EvolutionParameters) -> None:
        """Start without elites."""
        super().__init__(settings.space, settings.similarity)
        self._settings = settings
        self._values: dict[str, list[float]] = {}

    def times(self, elite: Elite) -> int:
        """How often an object has been evaluated."""
        return len(self._values.get(elite.id, ())) or 1

    def evaluate(self, elites: list[Elite]) -> int:
        """Evaluate objects once more and place them anew; returns how many there were."""
        for elite in elites:
            values = self._values.setdefault(elite.id, [elite.graspability])
            rng = generator(self._settings.seed, "again", elite.id, len(values))
            mesh = packed_surface(elite.voxels, self._settings.shape)
            values.append(rough_graspability(mesh, self._settings, rng).value)
            self._place(self._ids[elite.id], replace(elite, graspability=float(np.mean(values))))
        return len(elites)


class Adaptive(Repeated):
    """Before an offspring takes the slot of an elite, both are evaluated once more."""

    def __init__(self, settings: EvolutionParameters) -> None:
        """Start without elites."""
        super().__init__(settings)
        self._settled: set[str] = set()
        self.evaluations = 0

    def _trim(self) -> None:
        losing = [self._elites[index] for index in self._losers()]
        elites = [elite for elite in losing if elite.id in self._settled]
        contested, known = {self.cell(e) for e in elites}, self._settled | {e.id for e in losing}
        fresh = [elite for elite in self.elites if elite.id not in known]
        challengers = [elite for elite in fresh if self.cell(elite) in contested]
        self.evaluations += self.evaluate(elites + challengers)
        super()._trim()
        self._settled = set(self._ids)


def run(method: str, seed: int) -> pd.DataFrame:
    """One run, a row every 5000 evaluations: CPU time, values as selected and corrected."""
    compile_kernels()
    settings = settings_of(method, seed)
    kinds = {"adaptive": Adaptive, "depth": Repeated}
    archive = (
        kinds[method](settings) if method in kinds else Archive(settings.space, settings.similarity)
    )
    once = None if method == "sequential" else partial(measure, settings=settings)
    island, done, taken, rows = Island(archive, settings, 0, 0, evaluate=once), 0, 0.0, []
    true = cache(partial(_true, settings=settings))
    while done < EVALUATIONS:
        start = time.process_time()
        island.advance()
        done += settings.evolution.population
        if isinstance(archive, Adaptive):
            done, archive.evaluations = done + archive.evaluations, 0
        elif isinstance(archive, Repeated):
            chosen = sorted(archive.elites, key=lambda e: (archive.times(e), e.id))
            done += archive.evaluate(chosen[: STEP - settings.evolution.population])
            archive.add([])
        taken += time.process_time() - start
        if done // SNAPSHOT > len(rows):
            rows.append({"evaluations": done, "cpu": taken} | measures(archive.elites, true))
            print(method, seed, rows[-1], flush=True)
    return pd.DataFrame(rows).assign(method=method, seed=seed)


def _true(voxels: bytes, settings: EvolutionParameters) -> float:
    return independent(packed_surface(voxels, settings.shape), voxels.hex())


def measures(elites: list[Elite], true: Any) -> dict[str, float]:  # noqa: ANN401 (a cache)
    """Coverage and QD-score as selected and corrected, and how far the elites are off."""
    moved = [replace(elite, graspability=true(elite.voxels)) for elite in elites]
    selected, corrected = trimmed(elites), trimmed(moved)
    pairs = zip(elites, moved, strict=True)
    off = np.array([abs(corrected.cell(a)[1] - corrected.cell(b)[1]) for a, b in pairs])
    return {
        "coverage": selected.coverage,
        "corrected_coverage": corrected.coverage,
        "qd_score": selected.qd_score,
        "corrected_qd_score": corrected.qd_score,
        "in_cell": float((off == 0).mean()),
        "within_one": float((off <= 1).mean()),
    }


def trimmed(elites: list[Elite]) -> Archive:
    """An archive of the usual depth with some objects, which all count as certain."""
    archive = Archive(SPACE, settings_of("paper", 0).similarity)
    archive.add([replace(elite, cell_confidence=np.nan) for elite in elites])
    return archive


def main() -> None:
    """Write the figure and print the table."""
    rows = pd.concat(map(pd.read_csv, sorted(ROWS.glob("*.csv"))), ignore_index=True)
    names = [name for name in METHODS if name in set(rows["method"])]
    by_step = rows.assign(step=(rows["evaluations"] / SNAPSHOT).round())
    means = by_step.groupby(["method", "step"]).mean(numeric_only=True)
    with new_figure(9.6, 3.4) as drawing:
        grid = drawing.figure.subplots(1, 2, sharey=True)
        for axes, (column, title) in zip(
            grid, {"evaluations": "evaluations", "cpu": "CPU time, s"}.items(), strict=True
        ):
            for number, name in enumerate(names):
                curve, color = means.loc[name], line_color(number)
                axes.plot(curve[column], curve["corrected_coverage"], "-o", ms=3, color=color)
                axes.plot(curve[column], curve["coverage"], "--", lw=1, color=color)
                axes.plot([], [], "-o", ms=3, color=color, label=name)
            axes.set(xlabel=title, xlim=(0, None), ylim=(0, 1))
            show_percent(axes.yaxis)
            axes.grid(axis="y")
        grid[0].set_title("coverage: corrected, and as selected (dashed)", size=10, loc="left")
        grid[1].legend(loc="lower right")
    write_text(FOLDER / "noisy-search.svg", drawing.svg)
    print(table(rows, names))


def table(rows: pd.DataFrame, names: list[str]) -> str:
    """Means and ranges over the seeds at the end of the runs, and at the CPU time of `paper`.

    CPU times are compared within a seed, so all runs of a seed belong on one machine.
    """
    last = rows[rows["evaluations"] >= EVALUATIONS]
    limits = last[last["method"] == "paper"].set_index("seed")["cpu"]
    columns = ["corrected_coverage", "coverage", "corrected_qd_score", "qd_score"]
    heads = (
        "CPU s",
        "corrected coverage",
        "in the CPU time of paper",
        "illusory",
        "corrected QD-score",
        "illusory",
        "in cell, %",
        "within one, %",
    )
    lines = [f"| | {' | '.join(heads)} |", "| --- " * (1 + len(heads)) + "|"]
    for name in names:
        of = last[last["method"] == name]
        runs = rows[rows["method"] == name].groupby("seed")
        equal = np.mean([_at(each, limits[seed]) for seed, each in runs if seed in limits])
        real, seen, score, seen_score = (of[column] for column in columns)
        lines.append(
            f"| {name} | {of['cpu'].mean():.0f} | {real.mean():.3f} ({real.min():.3f} to "
            f"{real.max():.3f}) | {equal:.3f} | {(seen - real).mean():+.3f} | {score.mean():.0f} | "
            f"{(seen_score - score).mean():+.0f} | {100 * of['in_cell'].mean():.1f} | "
            f"{100 * of['within_one'].mean():.2f} |"
        )
    return "\n".join(lines)


def _at(run: pd.DataFrame, cpu: float) -> float:
    """Corrected coverage after some CPU time, interpolated between snapshots."""
    return float(np.interp(cpu, [0, *run["cpu"]], [0, *run["corrected_coverage"]]))


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] in METHODS:
        method, seed = sys.argv[1], int(sys.argv[2])
        ROWS.mkdir(exist_ok=True)
        run(method, seed).to_csv(ROWS / f"{method}-{seed}.csv", index=False, float_format="%.5g")
    else:
        main()
