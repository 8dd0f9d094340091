"""The tables of the study of scenes: goals, shares that are cleared, outcomes, scores.

Intervals are of 95 %, those of goals of 97.5 %, by bootstrap: the networks of a set and the rounds
are drawn with replacement. All detectors that are compared get the same rounds, and so do both
kinds of noise.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scene_charts import cleared_by, learning_chart
from scene_plan import PAIRS, PUBLISHED

from egad._util.arrays import Floats
from egad._util.files import write_text
from egad._util.markdown import table as markdown
from egad.bench.stats import by_difficulty
from egad.random import generator
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, ROUND
from egad.tables.objects import OBJECTS
from egad.tables.training import SCENE_SCORE
from egad_workflow.job import run_job

SCENE, CAMERAS = "pile", "six"  # the condition that counts
LEAD, MARGIN = 0.1, 0.05  # over published VGN; up to this far behind the rival is not behind
SURE = 0.975  # confidence of a goal, as either of two pairs of sets may reach it
DRAWS = 10_000


def run(
    tables: list[Path],
    scores: list[Path],
    objects: list[Path],
    sets: dict[str, list[str]],
    scenes: dict[str, int],
    out: Path,
    table: Path,
    chart: Path,
) -> None:
    """Write the tables.

    Args:
        tables: Cleared tables, `.../clutter/D/CAMERAS/P.parquet`.
        scores: Scores of the networks, `.../networks/SET/SEED/score.parquet`.
        objects: Objects of the tests, `results/D/objects.parquet`.
        sets: Networks of each set, by their names as detectors.
        scenes: Training scenes of each set.
        out: Markdown.
        table: Number of objects, and of cleared ones, in each round.
        chart: SVG of what is cleared over the training scenes: piles, six cameras, no noise.
    """
    names = {network: name for name, networks in sets.items() for network in networks}
    attempts = {path: parquet.read(path, CLUTTER) for path in tables}
    rounds = pd.concat([rounds_of(path, rows, names) for path, rows in attempts.items()])
    table.parent.mkdir(parents=True, exist_ok=True)
    rounds.to_parquet(table, index=False)
    clear = rounds[that_count(rounds) & (rounds["noise"] == "none")]
    shown = clear[clear["name"].isin([*scenes, *PUBLISHED])]
    write_text(chart, learning_chart(shown, scenes, PAIRS[0][0]))
    known = {path.parent.name: parquet.read(path, OBJECTS) for path in objects}
    parts = {"Goals": goals(rounds), "Scores": scored(scores)}
    for (cameras, scene), rows in rounds.groupby(["cameras", "scene"], sort=False):
        parts[f"Cleared, {scene}, cameras {cameras}"] = cleared(rows)
    for noise in rounds["noise"].unique():
        some = {path: rows[rows["noise"] == noise] for path, rows in attempts.items()}
        title = f"Piles, cameras {CAMERAS}, noise {noise}"
        parts[f"{title}, by outcome"] = outcomes(some, names)
        parts[f"{title}, cleared by thirds of the objects"] = thirds(some, names, known)
    write_text(out, "\n".join(f"## {title}\n\n{part}" for title, part in parts.items()))


def rounds_of(path: Path, rows: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Number of objects, and of cleared ones, in each round of a detector.

    Args:
        path: Of its table.
        rows: Columns of `tables.clutter.CLUTTER`.
        names: The set of each network.
    """
    found = rows.groupby(ROUND, sort=False).agg(
        cleared=("success", "sum"), there=("n_objects", "first")
    )
    return (
        found[found["there"] > 0]
        .reset_index()
        .assign(
            test=path.parents[1].name,
            cameras=path.parent.name,
            detector=path.stem,
            name=names.get(path.stem, path.stem),
        )
    )


def that_count(rounds: pd.DataFrame) -> pd.Series:
    """Which rounds the goals are about."""
    return (rounds["scene"] == SCENE) & (rounds["cameras"] == CAMERAS)


def goals(rounds: pd.DataFrame) -> str:
    """The pre-registered comparisons, as Markdown."""
    counts = rounds[that_count(rounds)]
    clear = counts[counts["noise"] == "none"]
    rows = []
    for ours, rival in PAIRS:
        for test, some in clear.groupby("test", sort=False):
            best = max(PUBLISHED, key=lambda name: share_of(some[some["name"] == name]))
            gain, (low, high) = difference([some], ours, best)
            met = gain >= LEAD and low > 0
            rows.append((f"{test}, no noise", ours, best, _points(gain, low, high), _yes(met)))
        tests = [some for _, some in counts.groupby("test", sort=False)]
        gain, (low, high) = difference(tests, ours, rival)
        rows.append(("all", ours, rival, _points(gain, low, high), _yes(low > -MARGIN)))
    return markdown(["tests", "set", "against", "difference, points", "met"], rows)


def difference(
    tests: Sequence[pd.DataFrame], first: str, second: str
) -> tuple[float, tuple[float, float]]:
    """The share of a set minus that of another, the mean over tests, and the interval of a goal."""
    shares = [
        share_of(some[some["name"] == first]) - share_of(some[some["name"] == second])
        for some in tests
    ]
    drawn = np.mean([draws(some, first, second) for some in tests], axis=0)
    return float(np.mean(shares)), _ends(drawn, SURE)


def share_of(rounds: pd.DataFrame) -> float:
    """The mean over detectors of the share of the objects that each clears."""
    return float(cleared_by(rounds)["share"].mean())


def interval(rounds: pd.DataFrame, name: str) -> tuple[float, float]:
    """The interval of the share of a set or detector, in a condition."""
    return _ends(np.clip(draws(rounds, name), 0, 1), 0.95)


def draws(rounds: pd.DataFrame, first: str, second: str | None = None) -> Floats:
    """Bootstrap draws of the share of a set or detector, or of that minus another one's.

    The networks that are drawn of a set are the same in every test. The mean of n drawn networks
    has (n - 1) / n of the variance that it should have, so its distance from the mean is stretched.

    Args:
        rounds: Of one test, and of conditions that count together.
        first: A set or detector.
        second: Another one.
    """
    names = [first] if second is None else [first, second]
    some = rounds[rounds["name"].isin(names)]
    wide = some.pivot_table(index="detector", columns=ROUND, values=["cleared", "there"])
    sums = wide.dropna(axis=1).T.groupby(level=[0, "scene", "round"]).sum().T
    counts = [sums[column] for column in ("cleared", "there")]
    size = counts[0].shape[1]
    drawn = generator(0, "rounds", *sorted(set(some["test"]))).integers(size, size=(DRAWS, size))
    values = np.zeros(DRAWS)
    for sign, name in zip((1, -1), names, strict=False):
        networks = sorted(set(some.loc[some["name"] == name, "detector"]))
        won, there = (
            np.stack(
                [each.loc[network].to_numpy(np.float64)[drawn].sum(axis=1) for network in networks]
            )
            for each in counts
        )
        rng = generator(0, "networks", name)
        count = len(networks)
        chosen = rng.integers(count, size=(count, DRAWS))
        shares = won / there
        mean = shares.mean(axis=0)
        away = np.take_along_axis(shares, chosen, axis=0).mean(axis=0) - mean
        values += sign * (mean + np.sqrt(count / max(count - 1, 1)) * away)
    return values


def _ends(values: Floats, level: float) -> tuple[float, float]:
    low, high = np.quantile(values, [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def cleared(rounds: pd.DataFrame) -> str:
    """The share that each set or detector clears with each noise of each test, as Markdown."""
    conditions = list(rounds.groupby(["test", "noise"], sort=False))
    rows = []
    for name in rounds["name"].unique():
        cells = []
        for _, some in conditions:
            low, high = interval(some, name)
            share = share_of(some[some["name"] == name])
            cells.append(_with_interval(100 * share, 100 * low, 100 * high, 0))
        rows.append((str(name), *cells))
    return markdown(["%", *(", ".join(map(str, key)) for key, _ in conditions)], rows)


def outcomes(attempts: Mapping[Path, pd.DataFrame], names: Mapping[str, str]) -> str:
    """Outcomes of the attempts of each set or detector, all tests together, as Markdown."""
    tables = [
        rows[rows["scene"] == SCENE].assign(name=names.get(path.stem, path.stem))
        for path, rows in attempts.items()
        if path.parent.name == CAMERAS
    ]
    every = pd.concat(tables)
    shares = pd.crosstab(every["name"], every["outcome"], normalize="index")
    rows = [(str(name), *(f"{100 * each:.0f}" for each in row)) for name, row in shares.iterrows()]
    return markdown(["%", *shares.columns], rows)


def thirds(
    attempts: Mapping[Path, pd.DataFrame],
    names: Mapping[str, str],
    objects: Mapping[str, pd.DataFrame],
) -> str:
    """The share that is cleared of each third of the objects of a test, as Markdown."""
    counts = [
        by_difficulty(rows[rows["scene"] == SCENE], objects[path.parents[1].name]).assign(
            test=path.parents[1].name, name=names.get(path.stem, path.stem)
        )
        for path, rows in attempts.items()
        if path.parent.name == CAMERAS
    ]
    sums = pd.concat(counts).groupby(["test", "name", "axis", "band"], sort=False).sum()
    shares = (sums["successes"] / sums["present"]).unstack(["axis", "band"])
    rows = [
        (str(test), str(name), *(f"{100 * each:.0f}" for each in row))
        for (test, name), row in zip(shares.index, shares.to_numpy(), strict=True)
    ]
    head = [" ".join(map(str, column)) for column in shares.columns]
    return markdown(["test", "%", *head], rows)


def scored(paths: Sequence[Path]) -> str:
    """Scores of each network on unseen scenes of its own set, as Markdown."""
    rows = []
    for path in paths:
        (row,) = parquet.records(parquet.read(path, SCENE_SCORE))
        share = row["n_positive"] / row["n_grasps"]
        name = f"{path.parents[1].name}-{path.parent.name}"
        rows.append(
            (
                name,
                _score(row, "average_precision", 2),
                f"{share:.2f}",
                _score(row, "angle_error", 1),
            )
        )
    return markdown(
        ["network", "average precision", "share of positives", "error of rotation, degrees"], rows
    )


def _score(row: Mapping[str, Any], name: str, digits: int) -> str:
    """A score with its interval."""
    value, low, high = (row[f"{name}{end}"] for end in ("", "_ci_low", "_ci_high"))
    return _with_interval(value, low, high, digits)


def _points(gain: float, low: float, high: float) -> str:
    return _with_interval(100 * gain, 100 * low, 100 * high, 1)


def _with_interval(value: float, low: float, high: float, digits: int) -> str:
    return f"{value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def _yes(is_met: bool) -> str:
    return "yes" if is_met else "no"


if __name__ == "__main__":
    run_job(run)
