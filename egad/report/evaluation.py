"""The section Evaluation set: its objects as a grid, in 3D, and as a page to print."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import trimesh
from matplotlib.figure import Figure

from egad.evalset import labels_of
from egad.grippers import Gripper
from egad.report.colors import INK, SOFT
from egad.report.drawing import STYLE
from egad.report.page import data_uri
from egad.report.pictures import render
from egad.report.viewer import GraspScene, viewer_data

PAGE = (8.27, 11.69)  # A4, inches
MOST_ROWS = 9  # on one A4 page; more make the page longer
PIXELS = 220


@dataclass(frozen=True)
class Slot:
    """A cell of the evaluation set; `item` is None if the dataset has no object for it."""

    label: str
    item: Mapping[str, Any] | None
    picture: str


@dataclass(frozen=True)
class EvaluationView:
    """The evaluation set of a dataset."""

    slots: list[list[Slot]]  # its rows, hardest first; each from simplest to most complex
    selected: int
    viewer: dict[str, Any] | None  # data of the 3D viewer; None if there are no grasps


def evaluation_view(
    evalset: pd.DataFrame,
    rows: int,
    columns: int,
    pictures: Mapping[str, bytes],
    scenes: Sequence[GraspScene],
    gripper: Gripper,
) -> EvaluationView:
    """What the section shows of a set, `EVAL49`; PNGs are by label of the set or dataset."""
    items = {item["label"]: item for item in evalset.to_dict("records")}
    labels = labels_of(rows, columns)
    slots = [
        [_slot(label, items.get(label), pictures) for label in labels[row * columns :][:columns]]
        for row in reversed(range(rows))
    ]
    viewer = viewer_data(scenes, gripper) if scenes else None
    return EvaluationView(slots, len(evalset), viewer)


def _slot(label: str, item: Mapping[Any, Any] | None, pictures: Mapping[str, bytes]) -> Slot:
    small = pictures.get(item["object_label"], b"") if item else b""
    return Slot(label, item, data_uri(pictures.get(label, small)) if item else "")


def contact_sheet(
    title: str,
    rows: int,
    columns: int,
    meshes: Mapping[tuple[int, int], trimesh.Trimesh],
    captions: Mapping[tuple[int, int], tuple[str, str]],
) -> bytes:
    """A PDF page with picture, name and size of each object by row and column of a set."""
    with matplotlib.rc_context({**STYLE, "pdf.fonttype": 42}):
        figure = Figure(figsize=(PAGE[0], PAGE[1] * max(1, rows / MOST_ROWS)))
        figure.suptitle(title, fontsize=12, y=0.98)
        figure.subplots_adjust(0.03, 0.03, 0.97, 0.94, 0.05, 0.35)
        for cell in np.ndindex(rows, columns):
            axes = figure.add_subplot(rows, columns, cell[0] * columns + cell[1] + 1)
            axes.set_axis_off()
            if cell in meshes:
                axes.imshow(render(meshes[cell], PIXELS))
            name, size = captions.get(cell, ("", ""))
            below: dict[str, Any] = {"ha": "center", "va": "top", "transform": axes.transAxes}
            axes.text(0.5, -0.02, name, color=INK, weight="bold", **below)
            axes.text(0.5, -0.17, size, color=SOFT, fontsize=6.5, **below)
        buffer = io.BytesIO()
        dates = {"CreationDate": None, "Producer": None, "Creator": None}
        figure.savefig(buffer, format="pdf", metadata=dates, dpi=PIXELS)
    return buffer.getvalue()
