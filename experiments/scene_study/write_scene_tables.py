"""The tables of the study of scenes: cleared shares, the pre-registered tests, scores."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.files import write_text
from egad._util.markdown import table
from egad.stats import MeanDifference, cleared_shares, difference_of_means, holm
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.training import SCENE_SCORE
from egad.workflow.job import run_job

GOAL = {"scene": "pile", "cameras": "six"}  # the condition that counts
OURS, PUBLISHED, RIVAL = "evolved", ("vgn", "vgn-half"), "primitives"
MARGIN = 0.1  # of `evolved` over published VGN


def run(tables: list[Path], scores: list[Path], out: Path, table: Path) -> None:
    """Write the tables.

    Args:
        tables: Cleared tables, `.../clutter/D/CAMERAS/P.parquet`.
        scores: Scores of the networks, `.../networks/SET/SEED/score.parquet`.
        out: Markdown.
        table: Success rate and share cleared of each detector in each condition, with the columns
            test, cameras, scene, noise, detector, name, success, cleared.
    """
    shares = pd.concat([shares_of(path) for path in tables], ignore_index=True)
    table.parent.mkdir(parents=True, exist_ok=True)
    shares.to_parquet(table)
    parts = [
        "## Goals\n\n" + goals(shares),
        "## Cleared\n\n" + cleared(shares),
        "## Scores\n\n" + scored(scores),
    ]
    write_text(out, "\n".join(parts))


def shares_of(path: Path) -> pd.DataFrame:
    """Success and cleared share of a detector in all conditions of a table."""
    rows = parquet.read(path, CLUTTER)
    both = cleared_shares(rows.assign(noise="all"))
    found = pd.concat([cleared_shares(rows), both], ignore_index=True)
    name, _, number = path.stem.rpartition("-")
    is_network = number.isdigit()
    return found.assign(
        test=path.parents[1].name,
        cameras=path.parent.name,
        detector=path.stem,
        name=name if is_network else path.stem,
    )


def goals(shares: pd.DataFrame) -> str:
    """The pre-registered comparisons, as Markdown."""
    chosen = shares[
        (shares["scene"] == GOAL["scene"])
        & (shares["cameras"] == GOAL["cameras"])
        & (shares["noise"] == "all")
    ]
    rows, p_values = [], []
    for test, some in chosen.groupby("test", sort=False):
        values = {str(name): each["cleared"].tolist() for name, each in some.groupby("name")}
        best = max((values[name] for name in PUBLISHED), key=lambda each: each[0])
        raised = [best[0] + MARGIN]
        for title, other in ((f"VGN + {100 * MARGIN:.0f}", raised), (RIVAL, values[RIVAL])):
            found = difference_of_means(values[OURS], other)
            rows.append((str(test), title, _percent(values[OURS]), _percent(other), _points(found)))
            p_values.append(found.p)
    corrected = holm(np.array(p_values))
    return table(
        ["piles, six views", "evolved against", "evolved", "other", "difference", "p, Holm"],
        [(*row, f"{p:.3f}") for row, p in zip(rows, corrected, strict=True)],
    )


def cleared(shares: pd.DataFrame) -> str:
    """Mean shares by detector or set, as Markdown, one row per detector."""
    keys = ["test", "cameras", "scene", "noise"]
    some = shares[shares["noise"] != "all"]
    wide = some.pivot_table(
        index="name", columns=keys, values="cleared", aggfunc="mean", sort=False
    )
    head = ["detector", *(", ".join(column) for column in wide.columns)]
    rows = [
        (str(name), *(f"{100 * value:.0f}" for value in values))
        for name, values in zip(wide.index, wide.to_numpy(), strict=True)
    ]
    return table(head, rows)


def scored(paths: Sequence[Path]) -> str:
    """Average precision of each network on unseen scenes of its own set, as Markdown."""
    rows = []
    for path in paths:
        (row,) = parquet.records(parquet.read(path, SCENE_SCORE))
        share = row["n_positive"] / row["n_grasps"]
        low, high = (row[f"average_precision_ci_{end}"] for end in ("low", "high"))
        interval = f"{row['average_precision']:.2f} ({low:.2f} to {high:.2f})"
        rows.append((f"{path.parents[1].name}-{path.parent.name}", interval, f"{share:.2f}"))
    return table(["network", "average precision", "share of positives"], rows)


def _percent(values: Sequence[float]) -> str:
    return f"{100 * float(np.mean(values)):.0f} %"


def _points(found: MeanDifference) -> str:
    low, high = (100 * end for end in found.interval)
    return f"{100 * found.gain:.1f} ({low:.1f} to {high:.1f})"


if __name__ == "__main__":
    run_job(run)
