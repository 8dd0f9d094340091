"""The look of charts: colors, fonts, and SVG text that is the same for the same data."""

import base64
import io
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.axis import Axis
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

INK, SOFT, FAINT = "#1c2430", "#667080", "#e4e7ec"
UNKNOWN = "#c4c9d1"
LINES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#8a6d3b"]
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
FONTS = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"

COLOR_MAP = "viridis"  # of values on maps of objects


class Drawing:
    """A figure to draw on; `svg` is its text once the block of `new_figure` has ended."""

    def __init__(self, width: float, height: float) -> None:
        self.figure = Figure(figsize=(width, height), layout="constrained")
        self.svg = ""


@contextmanager
def new_figure(width: float, height: float) -> Iterator[Drawing]:
    """An empty figure in the style of the report. Text stays text, in fonts of the reader's system.

    Args:
        width: Inches.
        height: Inches.
    """
    with matplotlib.rc_context(STYLE):
        drawing = Drawing(width, height)
        yield drawing
        buffer = io.StringIO()
        drawing.figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    drawing.svg = re.sub(r"font-family: [^;\"]*", f"font-family: {FONTS}", buffer.getvalue())


def show_percent(axis: Axis) -> None:
    """Write the ticks of an axis, which are parts of 1, as percentages."""
    axis.set_major_formatter(lambda value, _: f"{value:.0%}")


def line_color(number: int) -> str:
    """Color of a line of a chart, by its number; after the last one they repeat."""
    return LINES[number % len(LINES)]


def scale_color(value: float, low: float, high: float) -> str:
    """Color of a value on the scale `COLOR_MAP` from `low` to `high`, as `#rrggbb`.

    Values outside have the colors of the ends; NaN is grey.
    """
    if math.isnan(value):
        return UNKNOWN
    share = (value - low) / (high - low) if high > low else 0.5
    return to_hex(matplotlib.colormaps[COLOR_MAP](min(max(share, 0.0), 1.0)))


def ink_on(color: str) -> str:
    """Dark or white, whichever reads better on a color."""
    red, green, blue = to_rgb(color)
    return INK if 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.25 else "white"


def data_uri(content: bytes, kind: str = "image/png") -> str:
    """Content as an address that needs no file; empty for no content."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}" if content else ""


def svg_uri(svg: str) -> str:
    """The same of the text of an SVG figure."""
    return data_uri(svg.encode(), "image/svg+xml")
