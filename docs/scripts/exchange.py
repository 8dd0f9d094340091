"""Figure of `docs/exchange.md`: `python docs/scripts/exchange.py` draws the frames of the hand."""

from pathlib import Path
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from egad.exchange import graspgen_hand
from egad.exchange.grasps.acronym import PANDA_REACH
from egad.exchange.grasps.graspnet import DEPTH
from egad.grippers import GRIPPERS, BoxBody, finger_span

OUT = Path(__file__).parents[1] / "exchange.svg"
ACROSS, ALONG, AWAY = "#c1272d", "#1b62a5", "#2e7d32"
MM = 1000.0
PANDA = GRIPPERS["panda"]
PANDA_HAND = 0.10365  # metres from `panda_hand` to the pads in ManiSkill's panda_v2_gripper.urdf


class Frame(NamedTuple):
    """The frame of a format.

    Attributes:
        title: Above the picture.
        behind: How far its origin is behind the contacts, metres.
        closes: Name of the axis that the fingers close along.
        approaches: Name of the axis of the approach.
        away: Name of the axis that points away from the reader, or towards them with a minus.
    """

    title: str
    behind: float
    closes: str
    approaches: str
    away: str


FRAMES = (
    Frame("egad", 0.0, "x", "z", "y"),
    Frame("Dex-Net", 0.0, "y", "x", "z"),
    Frame("graspnet", DEPTH, "y", "x", "z"),
    Frame("ACRONYM", PANDA_REACH - finger_span(PANDA)[1], "x", "z", "y"),
    Frame("graspgen", graspgen_hand("panda", PANDA).depth, "x", "z", "y"),
    Frame("isaac_grasp, with the URDF of a Panda", PANDA_HAND, "y", "z", "-x"),
)


def draw_hand(axes: Axes) -> None:
    """The panda hand of the table of grippers, seen along y, around a ball."""
    for low, high in (part.box for part in BoxBody(PANDA).parts()):
        (left, bottom), (width, height) = MM * low[[0, 2]], MM * (high - low)[[0, 2]]
        colors = {"facecolor": "#e4e4e4", "edgecolor": "#777"}
        axes.add_patch(Rectangle((left, bottom), width, height, **colors))
    axes.add_patch(Circle((0, 0), 26, facecolor="#f3e3b3", edgecolor="#997a1f"))
    axes.plot([-26, 26], [0, 0], "D", ms=4, color="#222")


def draw_frame(axes: Axes, frame: Frame) -> None:
    """A frame: the closing axis points right, the approach up, the third away or towards."""
    height = -MM * frame.behind
    for step, color, name in (
        ((27, 0), ACROSS, frame.closes),
        ((0, 30), ALONG, frame.approaches),
    ):
        end = np.array([0, height]) + step
        arrow = {"arrowstyle": "-|>", "color": color, "lw": 2}
        axes.annotate("", end, (0, height), arrowprops=arrow)
        axes.text(*(end + np.array([3, -1])), name, color=color, weight="bold")
    axes.plot(0, height, "o", ms=10, mfc="white", mec=AWAY, mew=1.5)
    axes.plot(0, height, "." if frame.away.startswith("-") else "x", ms=6, color=AWAY)
    text = frame.away.removeprefix("-")
    axes.text(-10, height, text, color=AWAY, weight="bold", ha="right", va="center")


def figure() -> Figure:
    """The frames of all formats at the same hand."""
    drawn = Figure(figsize=(7.6, 5.3), layout="constrained")
    for axes, frame in zip(drawn.subplots(2, 3).flat, FRAMES, strict=True):
        draw_hand(axes)
        draw_frame(axes, frame)
        behind = f"{MM * frame.behind:.1f} mm behind the contacts"
        where = behind if frame.behind else "midway between the contacts"
        axes.set_title(f"{frame.title}\n{where}", fontsize=9)
        axes.set(xlim=(-106, 106), ylim=(-116, 44), aspect="equal")
        axes.axis("off")
    words = (
        ("◆ contacts", "#222"),
        ("closes", ACROSS),
        ("approaches", ALONG),
        ("\N{MULTIPLICATION SIGN} away from you, • towards you", AWAY),
    )
    for place, (text, color) in zip((0.1, 0.27, 0.4, 0.58), words, strict=True):
        drawn.text(place, 0.005, text, color=color, weight="bold", fontsize=9)
    drawn.get_layout_engine().set(rect=(0, 0.04, 1, 0.96))
    return drawn


if __name__ == "__main__":
    mpl.rcParams.update({"svg.hashsalt": "egad", "svg.fonttype": "none"})
    figure().savefig(OUT, metadata={"Date": None})
