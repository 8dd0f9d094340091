"""The style of charts, and SVG text that is the same for the same data."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.axis import Axis
from matplotlib.figure import Figure

from egad.report.colors import FAINT, FONTS, INK, SOFT

DASHED = (0, (4, 4))
THOUSANDTHS = "\N{MULTIPLICATION SIGN} 10\N{SUPERSCRIPT THREE}"
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "egad",
    "svg.fonttype": "none",
    "text.parse_math": False,
    "font.size": 10,
    "text.color": INK,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
}


class Drawing:
    """A figure to draw on; `svg` is its text once the block of `new_figure` has ended."""

    def __init__(self, width: float, height: float) -> None:
        self.figure = Figure(figsize=(width, height), layout="constrained")
        self.svg = ""


@contextmanager
def new_figure(width: float, height: float) -> Iterator[Drawing]:
    """An empty figure, inches, in the report's style. Text stays text, in fonts of the system."""
    with matplotlib.rc_context(STYLE):
        drawing = Drawing(width, height)
        yield drawing
        buffer = io.StringIO()
        drawing.figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    drawing.svg = re.sub(r"font-family: [^;\"]*", f"font-family: {FONTS}", buffer.getvalue())


def show_percent(axis: Axis) -> None:
    """Write the ticks of an axis, which are fractions of 1, as percentages."""
    axis.set_major_formatter(lambda value, _: f"{value:.0%}")
