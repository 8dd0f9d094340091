"""The numbers of a report, from its tables."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from egad.measures.grid import coverage, difficulty_cells, filled_cells
from egad.measures.parameters import Space
from egad.report.data import DatasetReport

Row = dict[str, Any]

PUBLISHED = pd.DataFrame(
    [
        ("EGAD, 2020", 2331, 0.93, 0.07, 0.27, 0.19),
        ("YCB", 78, 0.03, 0.11, 0.65, 0.19),
        ("Dex-Net 2.0", 1497, 0.37, 0.03, 0.26, 0.11),
    ],
    columns=[
        "dataset",
        "objects",
        "coverage",
        "diversity_min",
        "diversity_max",
        "diversity_mean",
    ],
)
"""EGAD (Morrison, Corke, Leitner 2020), Table III."""


def comparison_text(comparison: pd.DataFrame) -> str:
    """The table of datasets for a terminal, with the published ones beneath (EGAD, Table III).

    Args:
        comparison: Columns of `tables.objects.COMPARISON`.
    """
    titles = ("objects", "coverage", "diversity: min", "max", "mean")
    ours = [_comparison_line(row, 1) for row in comparison.to_dict("records")]
    theirs = [_comparison_line(row, 0) for row in PUBLISHED.to_dict("records")]
    return "\n".join([_columns("dataset", *titles), *ours, "published", *theirs])


def _comparison_line(row: Mapping[Any, Any], digits: int) -> str:
    values = [row[f"diversity_{name}"] for name in ("min", "max", "mean")]
    least, most, mean = ("-" if pd.isna(value) else f"{value:.2f}" for value in values)
    filled = f"{100 * row['coverage']:.{digits}f} %"
    return _columns(row["dataset"], str(row["objects"]), filled, least, most, mean)


def _columns(name: str, objects: str, filled: str, least: str, most: str, mean: str) -> str:
    return f"{name:20}{objects:>9}{filled:>10}{least:>16}{most:>6}{mean:>6}"


def space_numbers(objects: pd.DataFrame, space: Space) -> Row:
    """Objects, filled cells, coverage and diversity of a dataset."""
    diversity = objects["diversity"]
    filled = filled_cells(objects, space)
    return {
        "objects": len(objects),
        "cells": space.cells**2,
        "filled": round(filled * space.cells**2),
        "coverage": coverage(objects, space),
        "low": diversity.min(),
        "mean": diversity.mean(),
        "high": diversity.max(),
        "complexity": (objects["complexity"].min(), objects["complexity"].max()),
        "difficulty": (objects["difficulty"].min(), objects["difficulty"].max()),
    }


def regrading(objects: pd.DataFrame, space: Space) -> Row | None:
    """How the objects of an archive moved when they were graded again.

    Args:
        objects: Columns of `tables.objects.OBJECTS`.
        space: The cells.

    Returns:
        Parts of the objects that stayed in their cell, moved by one and by more, the mean move
        towards hard in cells, and the coverage before and after; None if no object was selected
        by a difficulty.
    """
    graded = objects.dropna(subset=["archive_difficulty"])
    if graded.empty:
        return None
    before = difficulty_cells(graded["archive_difficulty"], space)
    moves = graded["difficulty_cell"].to_numpy() - before
    return {
        "stayed": float((moves == 0).mean()),
        "by_one": float((abs(moves) == 1).mean()),
        "by_more": float((abs(moves) > 1).mean()),
        "mean": float(moves.mean()),
        "before": coverage(graded.assign(difficulty_cell=before), space),
        "after": coverage(graded, space),
    }


def grasp_numbers(gripper: str, grasps: pd.DataFrame) -> Row:
    """How many grasps a gripper has and how good they are."""
    per_object = grasps.groupby("label").size()
    return {
        "gripper": gripper,
        "objects": len(per_object),
        "grasps": len(grasps),
        "per_object": per_object.median() if len(per_object) else np.nan,
        "quality": grasps["quality"].quantile([0.25, 0.5, 0.75]).tolist(),
        "robust_quality": grasps["robust_quality"].quantile([0.25, 0.5, 0.75]).tolist(),
        "held": grasps["held"].mean(),
        "collision_free": grasps["collision_free"].mean(),
    }


def scale_numbers(gripper: str, data: DatasetReport) -> Row:
    """How the objects were scaled to a gripper, and what of them goes to the printer."""
    scales = data.scales.get(gripper)
    manifest = data.manifests.get(gripper)
    numbers: Row = {"gripper": gripper, "scaled": None, "printed": None}
    if scales is not None and len(scales):
        numbers["scaled"] = {
            "rule": ", ".join(sorted(scales["rule"].unique())),
            "opening": scales["opening"].iloc[0],
            "objects": len(scales),
            "changed": int((~np.isclose(scales["factor"], 1)).sum()),
            "factor": scales["factor"].quantile([0, 0.5, 1]).tolist(),
        }
    if manifest is not None:
        numbers["printed"] = {
            "objects": len(manifest),
            "plates": int(manifest["plate"].nunique()),
            "on_no_plate": manifest.loc[manifest["plate"].isna(), "label"].tolist(),
        }
    return numbers


def rejection_counts(rejected: pd.DataFrame) -> list[Row]:
    """Stage, reason and number of the objects left out, most frequent first."""
    counts = rejected.groupby(["stage", "reason"]).size().reset_index(name="count")
    ordered = counts.sort_values(["count", "stage", "reason"], ascending=[False, True, True])
    return [{str(key): value for key, value in row.items()} for row in ordered.to_dict("records")]


def outcome_counts(trials: pd.DataFrame) -> dict[str, int]:
    """Number of attempts by outcome: success first, then the failures, most frequent first."""
    counts = trials["outcome"].value_counts().to_dict()
    order = sorted(counts, key=lambda name: (name != "success", -counts[name], name))
    return {str(name): int(counts[name]) for name in order}
