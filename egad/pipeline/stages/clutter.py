"""clutter: rounds of clearing a table with a grasp detector, a shard of them."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from PIL import Image

from egad._util.child_process import Survivor
from egad._util.progress import phase, progress
from egad.benchmark import LABELS, Cleared, open_table
from egad.detectors import STARTING_TIME, DetectorConfig, FailureMonitor, keep_failure
from egad.errors import UserError
from egad.outcomes import Outcome
from egad.pipeline.parameters import Input, Output, Shard, command
from egad.pipeline.stages.bundled import ENGINE_TIME, model_in, rows_by_id
from egad.report.pictures import png_bytes
from egad.sim import (
    ClutterParameters,
    Pixels,
    Round,
    failed_round,
    film_round,
    picture_of,
    rounds_of,
    write_film,
)
from egad.sim.world import UnstableError
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.grasping import GRASPS

SHOWN = 4  # scenes of each kind
log = logging.getLogger(__name__)


class ClearedTables(ClutterParameters):
    """Rounds of clearing a table with a grasp detector."""

    detector: DetectorConfig


@command()
def run(
    settings: ClearedTables,
    bundle: Annotated[Path, Input()],
    shard: Shard,
    out: Annotated[Path, Output("D/clutter/G/P.parquet", CLUTTER)],
    grasps: Annotated[Path | None, Input()] = None,
) -> list[float]:
    """Let a grasp detector clear tables of several objects of the evaluation set.

    As in `simulate`, everything runs in a separate process. A round that crashes it twice is marked
    as crashed.

    Args:
        settings: Settings of this stage.
        bundle: Folder of the simulation bundle, scaled to the gripper.
        shard: Number of this shard, and number of shards; the rounds are dealt out among them.
        out: Rounds in which detector P clears a table of objects with gripper G, one attempt per
            row. Made for the detectors in `targets.clutter`.
        grasps: Labelled grasps of the objects, for the detector `labels`.

    Returns:
        Seconds that the detector took for each answer.
    """
    number, shards = shard
    todo = rounds_of(list(rows_by_id(bundle)), settings)[number::shards]
    tables, seconds = [parquet.empty(CLUTTER)], []
    phase("starting the simulator")
    attempt = settings.clutter.planning_time + STARTING_TIME + ENGINE_TIME
    monitor = FailureMonitor(len(todo), settings.clutter.keep_going, "rounds")
    limit = 2 * settings.clutter.objects * attempt
    with (
        keep_failure(out),
        Survivor(partial(open_bundle, settings, bundle, grasps), limit) as clear,
    ):
        for this in progress(todo, "clearing", len(todo)):
            done: Cleared | None = clear(this)
            if done is None:
                log.warning("round %d, %s: %s", this.number, this.scene, Outcome.CRASHED)
            table, times = done or (failed_round(this, settings, Outcome.CRASHED), [])
            tables.append(table)
            monitor.check(table)
            seconds += times
    whole = pd.concat([table for table in tables if len(table)] or tables)
    parquet.write(whole, CLUTTER, out)
    log.info("%d attempts, %d successes", len(whole), int(whole["success"].sum()))
    return seconds


@contextmanager
def open_bundle(
    settings: ClearedTables, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Round], Cleared]]:
    """A function that lets the detector clear one table of objects of a bundle."""
    known = rows_by_id(bundle)
    by_id = {} if grasps is None else dict(list(parquet.read(grasps, GRASPS).groupby("id")))
    none = parquet.empty(GRASPS)
    if settings.detector.detector == LABELS and grasps is None:
        raise UserError("the detector labels needs --grasps, the table of labelled grasps")
    model = cache(lambda name: model_in(bundle, known[name]))
    with open_table(
        settings.detector, model, lambda name: by_id.get(name, none), settings
    ) as clear:
        yield clear


def film(
    settings: ClutterParameters,
    table: Path,
    bundle: Path,
    name: tuple[str, str, int],
    out: Path,
) -> None:
    """Repeat a round without its detector, and film it.

    Args:
        settings: Settings of the rounds.
        table: Columns of `tables.clutter.CLUTTER`.
        bundle: Folder of the simulation bundle.
        name: Kind of scene, noise and number of the round.
        out: Film to write, `.gif` or `.mp4`.

    Raises:
        UserError: There is no such round, or it ends differently.
    """
    models = {each: model_in(bundle, row) for each, row in rows_by_id(bundle).items()}
    write_film(film_round(parquet.read(table, CLUTTER), *name, models, settings), out)


def scene_pictures(settings: ClutterParameters, bundle: Path) -> dict[str, list[bytes]]:
    """PNGs of the scenes that the first rounds begin with, by kind; those that can be simulated."""
    models = {name: model_in(bundle, row) for name, row in rows_by_id(bundle).items()}
    found: dict[str, list[bytes]] = {}
    for this in rounds_of(list(models), settings):
        if this.number < SHOWN and this.noise == settings.clutter.noise[0]:
            with suppress(UnstableError):
                found.setdefault(this.scene, []).append(_png(picture_of(this, models, settings)))
    return found


def _png(picture: Pixels) -> bytes:
    height, width = picture.shape[:2]
    small = Image.fromarray(picture).resize((width // 2, height // 2))
    return png_bytes(np.asarray(small.convert("RGBA")))
