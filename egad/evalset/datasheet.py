"""The datasheet of an evaluation set, in words and tables (ours)."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from egad._util.markdown import filled, table
from egad.evalset.filament import print_settings
from egad.evalset.parameters import PrintExport
from egad.evalset.selection import in_grid
from egad.tables import parquet

ATTEMPTS = 20  # as in the paper


@dataclass(frozen=True)
class ForGripper:
    """Data about the set, scaled for a gripper: `MANIFEST`, and best collision-free qualities.

    Qualities are by the name of the object in its dataset.
    """

    manifest: pd.DataFrame
    best: Mapping[str, float]


INTRODUCTION = """# Evaluation set of {dataset}

{count} of {cells} cells of the grid are filled. Rows A, B, ... go from easy to hard to grasp,
columns 0, 1, ... from simple to complex. `contact-sheet.pdf` shows all objects on one page.
{missing}"""
EVERY_OBJECT = """# Evaluation set of {dataset}

All {count} objects of the dataset, under their own names. `contact-sheet.pdf` shows them on one
page.
"""
OBJECTS = (
    "label",
    "object",
    "row",
    "column",
    "complexity, bit",
    "graspability, 1e-3",
    "distance to the nearest",
)
PRINTED = ("label", "scale", "size, mm", "mass, g", "best quality, 1e-3", "plate", "note")


def page(
    dataset: str,
    chosen: pd.DataFrame,
    empty: list[str],
    grippers: Mapping[str, ForGripper],
    export: PrintExport,
) -> str:
    """The datasheet as Markdown, from rows of `EVAL49` and data for each gripper.

    `empty` has the labels of cells without an object.
    """
    head = _introduction(dataset, chosen, empty)
    rows = [
        (
            row["label"],
            row["object_label"],
            row["row"],
            row["column"],
            f"{row['complexity']:.2f}",
            f"{1000 * row['graspability']:.2f}",
            _number(row["nearest"], 2),
        )
        for row in parquet.records(chosen)
    ]
    names = dict(zip(chosen["label"], chosen["object_label"], strict=True))
    tables = [_gripper_section(name, each, names) for name, each in grippers.items()]
    how = {"settings": print_settings(export), "attempts": ATTEMPTS}
    reporting = "\n" + filled(__package__, "reporting.md", **how)
    return "\n".join([head, table(OBJECTS, rows) + "".join(tables) + reporting])


def _introduction(dataset: str, chosen: pd.DataFrame, empty: list[str]) -> str:
    if not in_grid(chosen["label"]):
        return EVERY_OBJECT.format(dataset=dataset, count=len(chosen))
    borrowed = chosen.loc[chosen["borrowed"].astype(bool), "label"]
    missing = f"\nNo printable object lies in {' '.join(empty)}.\n" if empty else ""
    if len(borrowed):
        missing += (
            f"\n{' '.join(borrowed)}: no printable object lies in the cell itself; one from a "
            "neighboring cell takes its place.\n"
        )
    count = len(chosen)
    return INTRODUCTION.format(
        dataset=dataset, count=count, cells=count + len(empty), missing=missing
    )


def _gripper_section(name: str, known: ForGripper, objects: Mapping[str, str]) -> str:
    rows = []
    for row in parquet.records(known.manifest):
        size = " x ".join(_number(row[f"extents_{axis}"], 0) for axis in "xyz")
        best = 1000 * known.best.get(objects.get(row["label"], ""), float("nan"))
        plate = "" if pd.isna(row["plate"]) else f"{row['plate']:.0f}"
        rows.append(
            (
                row["label"],
                _number(row["factor"], 3),
                size,
                _number(row["filament"], 0),
                _number(best, 2),
                plate,
                row["note"],
            )
        )
    return (
        f"\n## For {name}\n\n"
        "Sizes are those of the box as printed. Mass is that of the filament, without supports. "
        "The best quality is that of the best labelled grasp that the hand reaches. "
        f"{_marks(known.manifest)}\n\n{table(PRINTED, rows)}"
    )


def _marks(manifest: pd.DataFrame) -> str:
    """How prints can be told apart."""
    engraved = manifest["engraved"].astype(bool)
    if not engraved.any():
        return (
            "The prints do not carry their labels. To tell them apart, mark each with a pen, or "
            "set `print_export: {engraving: true}` and make them again."
        )
    bare = manifest.loc[~engraved & manifest["plate"].notna(), "label"]
    return f"Each print carries its label{', except ' * bool(len(bare))}{', '.join(bare)}."


def _number(value: float, digits: int) -> str:
    return "" if pd.isna(value) else f"{value:.{digits}f}"
