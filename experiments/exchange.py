"""Figure of `docs/exchange.md`: `python experiments/exchange.py` draws the frames of the hand."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from egad.grasps import PANDA_REACH
from egad.grippers import BoxBody, finger_span
from egad.pipeline.config import GRIPPERS

OUT = Path(__file__).parents[1] / "docs/exchange.svg"
ACROSS, ALONG, AWAY = "#c1272d", "#1b62a5", "#2e7d32"
MM = 1000.0


def draw_hand(axes: Axes) -> None:
    """The panda hand of the table of grippers, seen along y, around a ball."""
    for low, high in (part.box for part in BoxBody(GRIPPERS["panda"]).parts()):
        (left, bottom), (width, height) = MM * low[[0, 2]], MM * (high - low)[[0, 2]]
        colors = {"facecolor": "#d9d9d9", "edgecolor": "#555"}
        axes.add_patch(Rectangle((left, bottom), width, height, **colors))
    axes.add_patch(Circle((0, 0), 26, facecolor="#f3e3b3", edgecolor="#997a1f"))


def draw_frame(axes: Axes, height: float, names: tuple[str, str, str]) -> None:
    """A frame at a height: what closes points right, what approaches up, the third away."""
    for step, color, name in (((30, 0), ACROSS, names[0]), ((0, 30), ALONG, names[1])):
        end = np.array([0, height]) + step
        arrow = {"arrowstyle": "-|>", "color": color, "lw": 2}
        axes.annotate("", end, (0, height), arrowprops=arrow)
        axes.text(*(end + np.array([3, 1])), name, color=color, weight="bold")
    axes.plot(0, height, "o", ms=9, mfc="white", mec=AWAY, mew=1.5)
    axes.plot(0, height, "x", ms=5, color=AWAY)
    axes.text(-9, height, names[2], color=AWAY, weight="bold", ha="right", va="center")


def figure() -> Figure:
    """The frames of the three formats at the same hand."""
    drawn = Figure(figsize=(7.6, 2.7), layout="constrained")
    panes = drawn.subplots(1, 3)
    behind = MM * (finger_span(GRIPPERS["panda"])[1] - PANDA_REACH)
    for axes, title, height, names in (
        (panes[0], "egad: between the contacts", 0.0, ("x", "z", "y")),
        (panes[1], "Dex-Net: the same place", 0.0, ("y", "x", "z")),
        (panes[2], f"ACRONYM: {-behind:.0f} mm behind it", behind, ("x", "z", "y")),
    ):
        draw_hand(axes)
        draw_frame(axes, height, names)
        axes.set_title(title, fontsize=9)
        axes.set(xlim=(-106, 106), ylim=(-112, 38), aspect="equal")
        axes.axis("off")
    for place, (text, color) in enumerate(
        (("closes", ACROSS), ("approaches", ALONG), ("points away from you", AWAY))
    ):
        drawn.text(0.24 + 0.18 * place, 0.01, text, color=color, weight="bold", fontsize=9)
    return drawn


if __name__ == "__main__":
    mpl.rcParams.update({"svg.hashsalt": "egad", "svg.fonttype": "none"})
    figure().savefig(OUT, metadata={"Date": None})
