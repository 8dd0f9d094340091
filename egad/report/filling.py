"""How an archive filled: curves over evaluations, and the map as a moving picture."""

import io
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from egad.measures.parameters import Space
from egad.report.style import LINES, drawn

THIN = "\N{NARROW NO-BREAK SPACE}"
FRAMES, UNIT, LAST = 60, 12, 2500  # pictures, pixels a cell, milliseconds of the last picture
GROUND, INK = (246, 247, 249), (28, 36, 48)
EMPTY, FULL = np.array([255, 255, 255]), np.array([11, 92, 173])


def evaluations(history: pd.DataFrame) -> pd.DataFrame:
    """The steps in the order in which they were made, with the offspring so far.

    Args:
        history: Columns of `tables.evolution.HISTORY`. Islands breed side by side: a row of the
            result is a step of all of them, and tells of the island that filled most.

    Returns:
        Columns offspring (so far), coverage, filled_cells, qd_score and cells.
    """
    ordered = history.sort_values(["epoch", "step", "coverage"])
    steps = ordered.groupby(["epoch", "step"])
    best = steps.tail(1).set_index(["epoch", "step"])
    return best.assign(offspring=steps["offspring"].sum().cumsum()).reset_index()[
        ["offspring", "coverage", "filled_cells", "qd_score", "cells"]
    ]


def filling_curves(histories: Mapping[str, pd.DataFrame]) -> str:
    """Coverage, filled cells and QD-score over evaluations.

    Args:
        histories: Tables with the columns of `tables.evolution.HISTORY`, by the name of the run.

    Returns:
        SVG text.
    """
    runs = {name: evaluations(history) for name, history in histories.items()}
    panels = {"coverage": "coverage", "filled_cells": "cells filled", "qd_score": "QD-score"}
    with drawn(9.6, 2.9) as drawing:
        grid = drawing.figure.subplots(1, 3)
        for axes, (column, title) in zip(grid, panels.items(), strict=True):
            for place, (name, run) in enumerate(runs.items()):
                known = run.dropna(subset=[column])
                colour = LINES[place % len(LINES)]
                axes.plot(known["offspring"], known[column], color=colour, lw=1.6, label=name)
            _finish(axes, title, share=column != "qd_score")
        if len(runs) > 1:
            handles, names = grid[0].get_legend_handles_labels()
            drawing.figure.legend(handles, names, loc="outside upper center", ncols=4)
    return drawing.svg


def _finish(axes: Axes, title: str, *, share: bool) -> None:
    axes.set(xlabel="evaluations", title=title, xlim=(0, None))
    axes.set_ylim(0, 1 if share else None)
    axes.title.set_fontsize(10)
    axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace(",", THIN))
    if share:
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axes.grid(axis="y")


def filling_film(history: pd.DataFrame, space: Space) -> bytes:
    """The map while it filled: the darker, the more elites a cell holds.

    Args:
        history: Columns of `tables.evolution.HISTORY`.
        space: The cells.

    Returns:
        An animated GIF; complexity goes to the right, difficulty up.
    """
    steps = evaluations(history)
    shown = np.unique(np.linspace(0, len(steps) - 1, min(FRAMES, len(steps))).astype(int))
    frames = [
        _frame(steps["cells"].iloc[index], int(steps["offspring"].iloc[index]), space)
        for index in shown
    ]
    buffer = io.BytesIO()
    times = [120] * (len(frames) - 1) + [LAST]
    frames[0].save(
        buffer, "gif", save_all=True, append_images=frames[1:], duration=times, loop=0, disposal=1
    )
    return buffer.getvalue()


def _frame(cells: bytes, offspring: int, space: Space) -> Image.Image:
    counts = np.frombuffer(cells, np.uint8).reshape(space.cells, space.cells)[::-1]
    pixels = np.kron(_colours(counts, space), np.ones((UNIT, UNIT, 1))).astype(np.uint8)
    image = Image.new("RGB", (pixels.shape[1], pixels.shape[0] + 2 * UNIT), GROUND)
    image.paste(Image.fromarray(pixels))
    text = f"{offspring} evaluations, {int(counts.sum())} objects"
    ImageDraw.Draw(image).text((4, pixels.shape[0] + 5), text, fill=INK)
    return image.quantize(32)


def _colours(counts: NDArray[np.uint8], space: Space) -> NDArray[np.float64]:
    share = np.minimum(counts / space.elites_per_cell, 1)[..., None]
    full = np.where(share > 0, 0.15 + 0.85 * share, 0)
    return np.asarray(EMPTY + full * (FULL - EMPTY))
