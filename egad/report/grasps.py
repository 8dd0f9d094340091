"""The section Grasps: quality of labelled grasps, its dependence on size, and object scales."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import trimesh
from matplotlib.axes import Axes

from egad._util.arrays import Floats
from egad.grippers import Gripper
from egad.measures import summarize
from egad.report.colors import FAINT, INK, SOFT, line_color
from egad.report.drawing import THOUSANDTHS, new_figure, show_percent
from egad.report.page import svg_uri
from egad.report.pictures import CAMERA, FILL, render

COLUMNS = 3
WIDTH, HEIGHT = 3.2, 3.7
QUARTILES = [0.25, 0.5, 0.75]
STEM, AROUND = 0.03, np.array([-0.07, 0.07])  # metres: behind a palm, around an object


@dataclass(frozen=True)
class GraspNumbers:
    """How many grasps a gripper has and how good they are."""

    objects: int
    grasps: int
    per_object: float  # median number of grasps of an object
    quality: list[float]  # quartiles of the Ferrari-Canny quality
    robust_quality: list[float]  # quartiles of the robust quality
    robust_success_rate: float  # mean fraction of the perturbed copies that hold
    collision_free: float  # fraction of the grasps that the hand reaches without collision


@dataclass(frozen=True)
class GraspView:
    """Grasps and sizes of the objects of a dataset, by gripper; figures are addresses."""

    grasps: dict[str, GraspNumbers]
    figure: str
    size_figures: dict[str, str]


def grasp_view(
    grasps: Mapping[str, pd.DataFrame], size_effects: Mapping[str, pd.DataFrame]
) -> GraspView | None:
    """What the section shows of GRASPS and SIZE_EFFECT tables by gripper; None if all are empty."""
    known = {name: table for name, table in grasps.items() if len(table)}
    charts = {
        name: svg_uri(size_chart(table)) for name, table in size_effects.items() if len(table)
    }
    if not (known or charts):
        return None
    numbers = {name: grasp_numbers(table) for name, table in known.items()}
    return GraspView(numbers, svg_uri(grasp_chart(known)) if known else "", charts)


def grasp_numbers(grasps: pd.DataFrame) -> GraspNumbers:
    """Numbers of a table of grasps, with the columns of `tables.grasping.GRASPS`."""
    per_object = grasps.groupby("label").size()
    return GraspNumbers(
        objects=len(per_object),
        grasps=len(grasps),
        per_object=per_object.median() if len(per_object) else np.nan,
        quality=grasps["quality"].quantile(QUARTILES).tolist(),
        robust_quality=grasps["robust_quality"].quantile(QUARTILES).tolist(),
        robust_success_rate=grasps["robust_success_rate"].mean(),
        collision_free=grasps["collision_free"].mean(),
    )


def grasp_chart(grasps: Mapping[str, pd.DataFrame]) -> str:
    """SVG histograms of nominal and robust quality, a line for each `tables.grasping.GRASPS`."""
    panels = {
        "quality": f"quality {THOUSANDTHS}",
        "robust_quality": f"robust quality {THOUSANDTHS}",
    }
    with new_figure(8.6, 2.7) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        for axes, (column, title) in zip((left, right), panels.items(), strict=True):
            _draw_histograms(axes, {name: table[column] * 1000 for name, table in grasps.items()})
            axes.set_xlabel(title)
        left.set_ylabel("share of the grasps")
        if len(grasps) > 1:
            drawing.figure.legend(
                *left.get_legend_handles_labels(), loc="outside upper center", ncols=5
            )
    return drawing.svg


def collision_chart(grasps: pd.DataFrame) -> str:
    """SVG histograms of nominal and robust quality of grasps with and without a collision."""
    free = grasps["collision_free"].astype(bool)
    groups = {"collision-free": grasps[free], "in collision": grasps[~free]}
    return grasp_chart({f"{len(table)} {name}": table for name, table in groups.items()})


def _draw_histograms(axes: Axes, values: Mapping[str, "pd.Series[float]"]) -> None:
    known = np.concatenate([series.dropna() for series in values.values()])
    top = known.max() if len(known) and known.max() > 0 else 1.0
    bins = np.linspace(min(0, known.min(initial=0)), top, 41)
    for number, (name, series) in enumerate(values.items()):
        color = line_color(number)
        share = np.histogram(series.dropna(), bins)[0] / max(len(series), 1)
        axes.stairs(share, bins, color=color, lw=1.6, label=name)
        axes.stairs(share, bins, color=color, fill=True, alpha=0.12)
    axes.set(xlim=(bins[0], bins[-1]))
    axes.set_ylim(bottom=0)
    show_percent(axes.yaxis)
    axes.grid(axis="y")


def hands_chart(mesh: trimesh.Trimesh, hands: Mapping[str, Floats], gripper: Gripper) -> str:
    """SVG of an object, metres, with open hands at poses (n, 4, 4): a panel for each title."""
    seen = (mesh.vertices @ CAMERA.T)[:, :2]
    middle, picture = (seen.min(axis=0) + seen.max(axis=0)) / 2, render(mesh, 480)
    reach = np.ptp(seen, axis=0).max() / 2 / FILL
    (palm, tip), half = gripper.kind.span, gripper.opening / 2
    outline = [[-half, tip], [-half, palm], [0, palm], [0, palm - STEM], [0, palm], [half, palm]]
    points = np.insert([*outline, [half, tip]], 1, 0, axis=1)
    with new_figure(4.3 * len(hands), 4.3) as drawing:
        panels = drawing.figure.subplots(1, len(hands), squeeze=False)[0]
        for axes, (title, poses) in zip(panels, hands.items(), strict=True):
            x, y = (center + np.array([-reach, reach]) for center in middle)
            axes.imshow(picture, extent=(*x, *y))
            axes.set(xlim=x + AROUND, ylim=y + AROUND, title=title)
            axes.set_axis_off()
            for number, pose in enumerate(poses):
                line = (points @ pose[:3, :3].T + pose[:3, 3]) @ CAMERA.T
                axes.plot(*line[:, :2].T, color=line_color(number), lw=1.6)
    return drawing.svg


def size_chart(table: pd.DataFrame) -> str:
    """SVG of percentiles of quality over size (`SIZE_EFFECT`), a panel per object."""
    numbers = summarize(table)
    names = list(dict.fromkeys(numbers["name"]))
    columns = min(COLUMNS, len(names))
    rows = math.ceil(len(names) / columns)
    with new_figure(WIDTH * columns + 0.8, HEIGHT * rows + 0.5) as drawing:
        grid = drawing.figure.subplots(
            2 * rows, columns, squeeze=False, sharex=True, sharey="row", height_ratios=[3, 1] * rows
        )
        highest = 1000 * float(np.nanmax([*numbers["high"], 0.0])) or 1.0
        panels = zip(grid[::2].ravel(), grid[1::2].ravel(), strict=True)
        for number, (upper, lower) in enumerate(panels):
            if number >= len(names):
                upper.set_axis_off()
                lower.set_axis_off()
                continue
            shown = numbers[numbers["name"] == names[number]]
            _draw_quality(upper, shown, highest, labelled=number == 0)
            upper.set_title(names[number], size=10)
            _draw_share(lower, shown)
            lower.tick_params(labelbottom=True)
        for upper, lower in zip(grid[::2, 0], grid[1::2, 0], strict=True):
            upper.set_ylabel(f"quality {THOUSANDTHS}")
            lower.set_ylabel("possible")
        drawing.figure.supxlabel("smallest side / opening of the gripper", size=10)
        handles, titles = grid[0, 0].get_legend_handles_labels()
        drawing.figure.legend(handles, titles, loc="outside upper center", ncols=4)
    return drawing.svg


def _draw_quality(axes: Axes, numbers: pd.DataFrame, highest: float, *, labelled: bool) -> None:
    for number, (percent, line) in enumerate(numbers.groupby("percentile")):
        known = line.dropna(subset=["mean"])
        color = line_color(number)
        size = known["fraction"]
        axes.fill_between(size, 1000 * known["low"], 1000 * known["high"], color=color, alpha=0.2)
        label = f"percentile {percent:g}" if labelled else None
        axes.plot(size, 1000 * known["mean"], color=color, lw=1.6, label=label)
        for whole, face in ((True, color), (False, "white")):
            points = known[(known["found"] == 1) == whole]
            across, height = points["fraction"], 1000 * points["mean"]
            axes.plot(across, height, "o", ms=4, color=color, mfc=face, zorder=3)
    axes.axvline(1, color=SOFT, lw=0.8, ls=":")
    axes.set_ylim(0, 1.05 * highest)
    axes.grid(axis="y")


def _draw_share(axes: Axes, numbers: pd.DataFrame) -> None:
    shares = numbers.drop_duplicates("fraction")
    axes.fill_between(shares["fraction"], shares["share"], color=FAINT)
    axes.plot(shares["fraction"], shares["share"], color=INK, lw=1)
    axes.axvline(1, color=SOFT, lw=0.8, ls=":")
    axes.set_ylim(0, 1)
    axes.set_yticks([0, 0.5, 1])
    show_percent(axes.yaxis)
