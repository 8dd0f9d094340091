"""The map of an archive, and a page that shows it while evolution fills it.

The page is HTML that opens offline and reloads by itself. Each island keeps its state in its own
file next to the page, and writes the page from the files of all islands of the same run. No result
depends on any of them.
"""

import json
import logging
import os
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from egad._util.progress import duration, rate_text
from egad.evolution import Archive, Elite, unpack
from egad.measures import MeasureSpace, cell_name, complexity_cells, difficulty_cells
from egad.report.axes import USUAL, AxisPair, named_axes
from egad.report.page import counted, data_uri, render_template
from egad.report.pictures import voxel_picture, voxel_png

log = logging.getLogger(__name__)

INTERVAL = 10.0  # minimum seconds between two versions of the page
SHARE = 0.01  # fraction of the time that may be spent on the page
UNIT = 40  # side of a cell of the map, pixels
MARGIN = 4  # pixels of a cell that its picture leaves free
MAX_SIDE = 96  # side of a picture, pixels
NARROWEST = 520  # minimum side of a map, pixels; cells of smaller maps are enlarged
POINTS = 200  # maximum number of points of a curve
State = dict[str, Any]
Cells = dict[str, tuple[int, str]]  # by name: how many objects, and a picture of one


@dataclass(frozen=True)
class EpochOfIsland:
    """What a page is about, shared by islands of a run and epoch; their number may be unknown."""

    run: str
    epoch: int
    island: int
    evaluations: int
    islands: int | None = None


class LiveMap:
    """Keeps the page up to date with one epoch of one island."""

    def __init__(
        self,
        page: Path,
        epoch: EpochOfIsland,
        space: MeasureSpace,
        resolution: int,
        axes: AxisPair = USUAL,
    ) -> None:
        """Write the page without objects; the islands' files are in the folder of its name."""
        self._page, self._epoch = page, epoch
        self._space, self._resolution, self._axes = space, resolution, axes
        self._pictures: dict[str, str] = {}
        self._start, self._next = time.monotonic(), 0.0
        self._write((), ())

    def __call__(self, archive: Archive, steps: Sequence[Mapping[str, Any]]) -> None:
        """Update the page, unless it was recently; a failure does not stop evolution."""
        last = sum(step["offspring"] for step in steps) >= self._epoch.evaluations
        if last or time.monotonic() >= self._next:
            if not self._pictures:  # draw those of the previous epoch once; not part of the share
                self._cells(archive.elites)
            begin = time.monotonic()
            self._write(archive.elites, steps)
            self._next = begin + max(INTERVAL, (time.monotonic() - begin) / SHARE)

    def _write(self, elites: Sequence[Elite], steps: Sequence[Mapping[str, Any]]) -> None:
        epoch, seconds = self._epoch, time.monotonic() - self._start
        state: State = {"run": epoch.run, "epoch": epoch.epoch, "island": epoch.island}
        state |= progress_of(steps, epoch.evaluations, seconds)
        state |= {"cells": self._cells(elites)}
        folder = self._page.with_suffix("")
        try:
            _write(folder / f"island-{epoch.island}.json", json.dumps(state))
            states = read_states(folder, state, epoch.islands)
            _write(self._page, page_of(states, self._space, self._axes))
        except OSError as error:
            log.warning("%s is not up to date: %s", self._page, error)

    def _cells(self, elites: Sequence[Elite]) -> Cells:
        """The filled cells. Pictures of elites that are still shown are reused."""
        kept, self._pictures = self._pictures, {}

        def picture(elite: Elite) -> str:
            found = kept.get(elite.id) or picture_of(elite.voxels, self._resolution)
            self._pictures[elite.id] = found
            return found

        return filled_cells(elites, self._space, picture)


def filled_cells(
    elites: Sequence[Elite], space: MeasureSpace, picture: Callable[[Elite], str]
) -> Cells:
    """Number of elites, oldest first, and `href` of the oldest's picture, by name of the cell."""
    columns = complexity_cells([elite.complexity for elite in elites], space)
    rows = difficulty_cells([elite.graspability for elite in elites], space)
    names = [cell_name(int(column), int(row)) for column, row in zip(columns, rows, strict=True)]
    counts, first = Counter(names), dict[str, Elite]()
    for name, elite in zip(names, elites, strict=True):
        first.setdefault(name, elite)
    return {name: (counts[name], picture(elite)) for name, elite in first.items()}


def picture_of(packed: bytes, resolution: int, size: int = UNIT - MARGIN) -> str:
    """A picture of voxels as archives keep them, for the attribute `href` of an image."""
    return data_uri(voxel_png(voxel_picture(unpack(packed, resolution), size)))


def archive_map(archive: Archive, measures: tuple[str, str] | None = None) -> str:
    """SVG map of an archive, with the oldest object of each cell; axes are named by measures."""
    unit = max(UNIT, NARROWEST // archive.space.cells)
    size = min(unit - MARGIN, MAX_SIDE)

    def picture(elite: Elite) -> str:
        return picture_of(elite.voxels, round((8 * len(elite.voxels)) ** (1 / 3)), size)

    cells = filled_cells(archive.elites, archive.space, picture)
    axes = USUAL if measures is None else named_axes(*measures)
    caption = (
        f"{counted(len(archive), 'object')} in {len(cells)} of {archive.space.cells**2} cells, "
        f"coverage {100 * archive.coverage:.1f} %; darker: more objects"
    )
    values = map_values(cells, archive.space, axes)
    return render_template("archive_map.svg.j2", **values, unit=unit, caption=caption)


def map_values(cells: Cells, space: MeasureSpace, axes: AxisPair) -> dict[str, Any]:
    """What the template of the map reads besides the size of a cell and a caption."""
    size = range(space.cells)
    (start, end), (hard, easy) = space.complexity_range, space.graspability_range
    return {
        "cells": cells,
        "size": space.cells,
        "capacity": space.elites_per_cell,
        "names": [[cell_name(column, row) for column in size] for row in size],
        "across": axes.across.along(start, end),
        "upwards": axes.upwards.along(easy, hard),
    }


def progress_of(steps: Sequence[Mapping[str, Any]], total: int, seconds: float) -> State:
    """Progress of an epoch after some seconds: numbers, and texts to show."""
    done, curve = 0, []
    for step in steps:
        done += step["offspring"]
        curve.append((done, step["coverage"]))
    rate = done / seconds if seconds > 0 else 0.0
    return {
        "done": done,
        "total": total,
        "over": done >= total,
        "coverage": curve[-1][1] if curve else 0.0,
        "elites": steps[-1]["elites"] if steps else 0,
        "curve": curve[:: len(curve) // POINTS + 1],
        "rate": rate_text(rate) if rate else "",
        "left": duration((total - done) / rate) if 0 < done < total else "",
        "taken": duration(seconds),
    }


def read_states(folder: Path, own: State, islands: int | None = None) -> list[State]:
    """What the islands wrote in the run and epoch of `own`, in the order of their numbers."""
    found: list[State] = []
    for path in folder.glob("island-*.json"):
        with suppress(OSError, ValueError, LookupError, TypeError):
            state = json.loads(path.read_text(encoding="utf-8"))
            current = islands is None or state["island"] < islands
            same = (state["run"], state["epoch"], *state) == (own["run"], own["epoch"], *own)
            found += [state] if current and same else []
    return sorted(found, key=lambda state: int(state["island"]))


def page_of(states: Sequence[State], space: MeasureSpace, axes: AxisPair = USUAL) -> str:
    """The page of the states of all islands."""
    cells: Cells = {}
    for state in states:
        for name, (count, picture) in state["cells"].items():
            cells[name] = max(cells.get(name, (0, "")), (count, picture), key=lambda cell: cell[0])
    return render_template(
        "live_map.html.j2",
        states=states,
        over=all(state["over"] for state in states),
        now=time.strftime("%H:%M:%S"),
        unit=UNIT,
        caption="",
        **map_values(cells, space, axes),
    )


def _write(path: Path, text: str) -> None:
    """Write a file atomically; several islands may do so at the same time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)
