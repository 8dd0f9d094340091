"""A report card of hands: what each can do, how easily, with a detector, and what none can."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad._util.files import as_path, write_text
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.hands import HandComparison, film_attempt_of_hand
from egad.bench.stats import Mean, mean_rate, trial_grid
from egad.errors import UserError
from egad.evalset import SelectEval, in_grid
from egad.geometry import Rescale
from egad.grippers import Gripper
from egad.objects import NamedMesh, scaled_solid
from egad.report.colors import INK, line_color
from egad.report.drawing import new_figure, show_percent
from egad.report.failure_atlas import animation
from egad.report.hand_shape import hand_shapes, painted
from egad.report.page import counted, data_uri, render_template, svg_uri
from egad.report.pictures import png_bytes, render
from egad.report.trial_charts import trial_heat_map
from egad.tables import parquet
from egad.tables.hands import GRASPERS, Cause

FILMS = 3
BIN = 0.02  # metres: of the sides by which objects are grouped
PICTURE = 192  # pixels
SIDES = {"smallest_side": "smallest side", "longest_side": "longest side"}


class Shown(NamedTuple):
    """A film of an attempt at an object that one hand never holds."""

    hand: str
    cause: str
    film: str  # a data URI; empty if there is no film


class Impossible(NamedTuple):
    """An object that a hand held in no attempt."""

    label: str
    picture: str  # a data URI
    attempts: int
    causes: str  # how its attempts ended, in words
    films: list[Shown]
    note: str = ""


def write_card(
    card: HandComparison,
    path: str | Path,
    targets: Sequence[NamedMesh],
    *,
    films: int = FILMS,
    jobs: int = 1,
) -> None:
    """Write a page that compares hands and needs no other file.

    Args:
        card: The comparison.
        path: The page to write.
        targets: The objects of the comparison, as it got them.
        films: Number of objects with films, for each hand, among those that it never held.
        jobs: Processes.
    """
    known = {target.label: target for target in targets}
    lost = {name: card.never_held(name) for name in card.hands}
    wanted = [
        (name, known[label], number < films)
        for name, rows in lost.items()
        for number, label in enumerate(rows["label"].unique())
    ]
    with workers(jobs) as mapper:
        work = partial(_impossible, card=card)
        shown = list(progress(mapper(work, wanted), "filming", len(wanted)))
    impossible = {
        hand: [each for (name, *_), each in zip(wanted, shown, strict=True) if name == hand]
        for hand in card.hands
    }
    write_text(as_path("path", path), page(card, impossible))


def page(card: HandComparison, impossible: Mapping[str, Sequence[Impossible]]) -> str:
    """The page, from a comparison and the objects that each hand never held."""
    some = card.attempts(next(iter(card.hands)))
    rates = {who: card.rates(who) for who in GRASPERS}
    ranks = {who: card.ranks(who) for who in GRASPERS}
    return render_template(
        "hands_page.html.j2",
        card=card,
        trials=card.settings.hands,
        graspers=GRASPERS,
        objects=some["label"].nunique(),
        scaled=card.rule != "none",
        share=Rescale().side_fraction,
        pictures={name: hand_picture(hand) for name, hand in card.hands.items()},
        rates=rates,
        ranks=ranks,
        figure=svg_uri(rate_chart(card)),
        causes={who: card.causes(who) for who in GRASPERS},
        all_causes=list(Cause),
        differences=differences(card),
        conclusions=card.conclusions(),
        maps=maps(card),
        sizes=by_size(card),
        impossible=impossible,
        counted=counted,
    )


def hand_picture(gripper: Gripper) -> str:
    """A picture of the open hand, fingers up, as a data URI."""
    mesh, _ = painted(hand_shapes(gripper, gripper.opening if gripper.kind.closes else 0.0))
    return data_uri(png_bytes(render(mesh, PICTURE)))


def rate_chart(card: HandComparison) -> str:
    """SVG of the success rate of each hand with each grasper, with intervals of 95 %."""
    names, step = list(card.hands), 0.2
    with new_figure(6.4, 0.9 + 0.55 * len(names)) as drawing:
        axes = drawing.figure.add_subplot()
        for number, who in enumerate(GRASPERS):
            y = -np.arange(len(names)) + (1 - number) * step
            rates = list(card.rates(who).values())
            for at, rate in zip(y, rates, strict=True):
                axes.hlines(at, *rate.interval, color=line_color(number), lw=1.4)
            values = [rate.value for rate in rates]
            axes.plot(values, y, "o", color=line_color(number), ms=5, label=GRASPERS[who])
        axes.set_yticks(-np.arange(len(names)), names, color=INK)
        axes.set(xlim=(0, 1), ylim=(-len(names) + 0.45, 0.55))
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x")
        show_percent(axes.xaxis)
        drawing.figure.legend(loc="outside upper left", ncols=3, fontsize=8)
    return drawing.svg


def differences(card: HandComparison) -> list[dict[str, Any]]:
    """The difference of each hand to the first, by grasper."""
    first, *others = card.hands
    return [
        {"hand": name, "grasper": GRASPERS[who], "result": card.compare(name, first, who)}
        for name in others
        for who in GRASPERS
    ]


def maps(card: HandComparison) -> dict[str, str]:
    """Heat maps of the best grasps of each hand by its name; none unless objects are of the set."""
    labels = set(card.table["label"])
    rows, columns = SelectEval().rows, SelectEval().columns
    if not in_grid(labels):
        return {}
    grids = {name: trial_grid(card.attempts(name), rows, columns) for name in card.hands}
    return {
        name: svg_uri(trial_heat_map(grid, rows, columns, labels))
        for name, grid in grids.items()
        if grid.cells
    }


def by_size(card: HandComparison) -> list[tuple[str, int, dict[str, Mean]]]:
    """Groups of objects by their sides, how many, and rates of the best grasps by hand."""
    found = []
    for column, title in SIDES.items():
        sides = card.table.drop_duplicates("label").set_index("label")[column]
        bins = np.floor(sides / BIN).astype(int)
        for number, labels in bins.groupby(bins).groups.items():
            low, high = (
                round(1000 * BIN * end) for end in (int(str(number)), int(str(number)) + 1)
            )
            rates = {
                name: mean_rate(rows[rows["label"].isin(labels)])
                for name in card.hands
                for rows in [card.attempts(name)]
            }
            found.append((f"{title} {low} to {high} mm", len(labels), rates))
    return found


def _impossible(item: tuple[str, NamedMesh, bool], card: HandComparison) -> Impossible:
    """An object that a hand never held, perhaps with films of it and of another that does."""
    hand, target, with_films = item
    mesh = scaled_solid(target, Gripper(opening=card.settings.hands.size), card.rule)
    rows = card.table[card.table["label"] == target.label]
    own = rows[rows["hand"] == hand]
    counts = own["cause"].value_counts()
    words = ", ".join(f"{str(name).replace('_', ' ')} {count}" for name, count in counts.items())
    picture = data_uri(png_bytes(render(mesh, PICTURE)))
    films: list[Shown] = []
    note = ""
    try:
        if with_films:
            films = [_film(card, target, row) for row in _telling_rows(rows, hand)]
    except UserError as reason:
        note = f"No film: {reason}."
    return Impossible(target.label, picture, len(own), words, films, note)


def _telling_rows(rows: pd.DataFrame, hand: str) -> list[dict[str, Any]]:
    """An attempt of a hand at an object, the best it has, and one of another hand that holds it."""
    order = pd.Categorical(rows["grasper"], ["best", "search", "detector", "naive"], ordered=True)
    tried = rows.assign(order=order).sort_values(["order", "drop"], kind="stable")
    tried = tried[tried["pose"].map(len) > 0]
    own, others = tried[tried["hand"] == hand], tried[(tried["hand"] != hand) & tried["success"]]
    return parquet.records(pd.concat([own.head(1), others.head(1)]))


def _film(card: HandComparison, target: NamedMesh, row: dict[str, Any]) -> Shown:
    film = animation(film_attempt_of_hand(card, target, row))
    return Shown(row["hand"], row["cause"].replace("_", " "), data_uri(film, "image/webp"))
