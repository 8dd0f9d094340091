"""The drawing of docs/grasps.md: `python docs/scripts/grasps.py`."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from egad._util.files import atomic_output
from egad.grippers import GRIPPERS, BoxBody, finger_span

DOCS = Path(__file__).parents[1]
HAND = GRIPPERS["egad_75mm"]
FINGER, PALM, OBJECT, LINE = "#7fa6c9", "#4a6f94", "#e3c59a", "#b03a2e"
ANGLES = 16


def main() -> None:
    """Write the drawing beside this file."""
    mpl.rcParams.update({"svg.hashsalt": "egad", "font.size": 9})
    figure = Figure(figsize=(11.5, 5), layout="constrained")
    front, side, around = figure.subplots(1, 3, width_ratios=[216, 104, 144])
    draw_front(front)
    draw_side(side)
    draw_angles(around)
    with atomic_output(DOCS / "grasps.svg") as temporary:
        figure.savefig(temporary, format="svg", metadata={"Date": None})


def draw_hand(axes: Axes, across: int) -> None:
    """The boxes of the hand, millimetres, `across` to the right and the approach downwards."""
    for part, color in zip(BoxBody(HAND).parts(), (FINGER, FINGER, PALM), strict=True):
        low, high = 1000 * part.box[:, [across, 2]]
        corner = (low[0], -high[1])
        axes.add_patch(Rectangle(corner, *(high - low), facecolor=color, edgecolor="black", lw=0.8))


def draw_front(axes: Axes) -> None:
    """Seen along y: the closing and approach axes, and the lengths in the table of grippers."""
    draw_hand(axes, 0)
    axes.add_patch(Ellipse((0, 8), 52, 44, facecolor=OBJECT, edgecolor="black", lw=0.8))
    axes.plot([-24.2, 24.2], [0, 0], "o", color=LINE, ms=4)
    base, tip = (1000 * length for length in finger_span(HAND))
    half = 500 * HAND.opening
    thick, length = 1000 * HAND.finger_thickness, 1000 * HAND.palm[2]
    measure(axes, (-half, -28), (half, -28), "opening")
    measure(axes, (-24.2, 12), (24.2, 12), "width")
    measure(axes, (half + thick + 6, -tip), (half + thick + 6, -base), "finger_length")
    measure(axes, (half, -28), (half + thick, -28), "finger_thickness", shift=7)
    wide, top = 500 * HAND.palm[0], length - base + 6
    measure(axes, (-wide, top), (wide, top), "palm[0]", shift=-10)
    arrow(axes, (0, 0), (15, 0), "x")
    arrow(axes, (0, 0), (0, -15), "z")
    axes.plot(0, -base, "+", color="white", ms=9)
    axes.text(4, -base + 4, "origin of a palm mesh", color="white", fontsize=8)
    axes.set_title("x closes, z approaches")
    finish(axes, (-108, 108), (-45, 130))


def draw_side(axes: Axes) -> None:
    """Seen along x: the pads."""
    draw_hand(axes, 1)
    axes.plot(0, 0, "o", color=LINE, ms=4)
    side, tip = 500 * HAND.finger_width, 1000 * finger_span(HAND)[1]
    axes.add_patch(
        Rectangle((-side, -tip), 2 * side, 2 * tip, facecolor="none", edgecolor=LINE, ls="--")
    )
    axes.text(side + 4, 7, "pad", color=LINE, va="center")
    measure(axes, (-side, -28), (side, -28), "finger_width")
    measure(axes, (-500 * HAND.palm[1], 116), (500 * HAND.palm[1], 116), "palm[1]", shift=-10)
    arrow(axes, (0, 0), (15, 0), "y")
    arrow(axes, (0, 0), (0, -15), "z")
    axes.set_title("along x, which goes into the page")
    finish(axes, (-52, 52), (-45, 130))


def draw_angles(axes: Axes) -> None:
    """The angles tried, seen along the closing axis."""
    axes.add_patch(Ellipse((0, 0), 34, 26, facecolor=OBJECT, edgecolor="black", lw=0.8))
    for number in range(ANGLES):
        turn = 2 * np.pi * number / ANGLES
        back = np.array([np.sin(turn), np.cos(turn)])
        axes.annotate(
            "", 24 * back, 55 * back, arrowprops={"arrowstyle": "->", "color": PALM, "lw": 1.2}
        )
        axes.text(*(62 * back), str(number), ha="center", va="center")
    axes.set_title(f"{ANGLES} approaches, seen as in the middle")
    axes.text(0, -80, "0 is as near to straight down\nas the axis allows", ha="center", va="center")
    finish(axes, (-72, 72), (-90, 72))


def measure(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], name: str, shift: float = 0.0
) -> None:
    """A length with its name."""
    axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", "lw": 0.8})
    upright = start[0] == end[0]
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    place = (middle[0] + 3, middle[1]) if upright else (middle[0], middle[1] - 5 - shift)
    side = "left" if upright else "center"
    axes.text(*place, name, ha=side, va="center", fontsize=8, rotation=90 * upright)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], name: str) -> None:
    """An axis of the frame."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": LINE, "lw": 1.5})
    axes.text(end[0] * 1.3, end[1] * 1.3, name, color=LINE, ha="center", va="center")


def finish(axes: Axes, across: tuple[float, float], upwards: tuple[float, float]) -> None:
    """Equal scales, no frame."""
    axes.set(xlim=across, ylim=upwards, aspect="equal")
    axes.set_axis_off()


if __name__ == "__main__":
    main()
