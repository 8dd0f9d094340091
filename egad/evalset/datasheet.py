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
    return filled(
        __package__,
        "datasheet.md",
        dataset=dataset,
        introduction=_introduction(chosen, empty),
        objects=table(OBJECTS, rows),
        grippers="".join(_gripper_section(*each, names) for each in grippers.items()),
        settings=print_settings(export),
        attempts=ATTEMPTS,
    )


def _introduction(chosen: pd.DataFrame, empty: list[str]) -> str:
    sheet = "`contact-sheet.pdf` shows them on one page."
    if not in_grid(chosen["label"]):
        return f"All {len(chosen)} objects of the dataset, under their own names. {sheet}"
    parts = [
        f"{len(chosen)} of {len(chosen) + len(empty)} cells of the grid are filled. Rows A, B, ... "
        f"go from easy to hard to grasp, columns 0, 1, ... from simple to complex. {sheet}"
    ]
    if empty:
        parts.append(f"No printable object lies in {' '.join(empty)}.")
    borrowed = chosen.loc[chosen["borrowed"].astype(bool), "label"]
    if len(borrowed):
        parts.append(
            f"{' '.join(borrowed)}: no printable object lies in the cell itself; one from a "
            "neighboring cell takes its place."
        )
    return "\n\n".join(parts)


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
