"""The page of an atlas: its tables, measured shape features, and films of repeated attempts."""

import io
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from egad._util.arrays import RgbImage
from egad._util.files import as_path, write_text
from egad._util.parameters import check_count
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench import ContactRule
from egad.bench.failures import (
    SHAPE_FEATURES,
    FailureAtlas,
    FailureParameters,
    ObjectVerdict,
    film_attempts,
    shape_features,
    shares,
)
from egad.bench.failures.evidence import by_object, failed_drops
from egad.bench.failures.models import scaled_surface
from egad.errors import UserError
from egad.objects import Dataset, load
from egad.random import generator
from egad.report.axes import axis_pair
from egad.report.failures import AttemptFilm, Example, FeatureShare, SearchText, page, worst
from egad.report.pictures import png_bytes, render
from egad.tables import parquet

MIN_FAILURES = 10  # for shares of the failures that shape features explain
MAX_SOLVED = 200  # objects that failures are compared with
EVERY = 2  # one of this many frames of the simulation is kept: 10 frames per second
FRAME_TIME, LAST_TIME = 100, 1200  # milliseconds
QUALITY = 55  # of WebP
PICTURE = 192  # pixels


def write_page(
    atlas: FailureAtlas,
    path: str | Path,
    films: int = 20,
    *,
    objects: Dataset | None = None,
    jobs: int = 1,
) -> None:
    """Write an HTML page, which needs no other file, that explains the failures of a detector.

    The worst failures have films of detector and reference at the same drop, at most `films`, about
    10 s each. From ten failures on, the page shows the shape features that distinguish them. The
    map is beside that of the objects: by default the released ones, or those looked at. UserError
    if the atlas does not say how it was made, or a number is not allowed.
    """
    file = as_path("path", path)
    if films:
        check_count("films", films)
    settings = atlas.settings
    if settings is None:
        raise UserError("the atlas does not say with which gripper it was made; load a saved one")
    chosen = parquet.records(worst(atlas.table, max(films, 20)))
    attempts = by_object(atlas.attempts)
    solved = solved_objects(atlas.examined, settings.seed)
    show = partial(_example, attempts=attempts, settings=settings)
    measure = partial(_features, attempts=attempts, settings=settings)
    compared = {"failures": atlas.table, "solved objects": solved}
    with workers(jobs) as mapper:
        measured = [
            pd.DataFrame(
                progress(mapper(measure, parquet.records(table)), f"measuring {what}", len(table)),
                columns=list(SHAPE_FEATURES),
            )
            for what, table in (compared.items() if len(atlas) >= MIN_FAILURES else ())
        ]
        filmed = [(row, number < films) for number, row in enumerate(chosen)]
        examples = list(progress(mapper(show, filmed), "filming", len(filmed)))
    text = page(
        atlas.table,
        atlas.examined,
        atlas.attempts,
        search=_search_text(atlas.detector, settings),
        dataset=_dataset(atlas.examined, objects),
        features=_feature_shares(*measured) if measured else [],
        examples={row["id"]: each for row, each in zip(chosen, examples, strict=True)},
        space=settings.breeding.space,
        axes=axis_pair(settings.breeding.measures),
    )
    write_text(file, text)


def solved_objects(examined: pd.DataFrame, seed: int) -> pd.DataFrame:
    """At most 200 of `tables.failures.EXAMINED` that the detector solves, drawn at random."""
    found = examined[examined["verdict"] == ObjectVerdict.DETECTOR_SUCCEEDS]
    found = found[found["voxels"].map(len) > 0].drop_duplicates("id")
    order = generator(seed, "solved objects").permutation(len(found))[:MAX_SOLVED]
    return found.iloc[np.sort(order)]


def film_rows(attempts: pd.DataFrame, engine: str) -> pd.DataFrame:
    """Detector's and reference's attempts at the drop that shows a failure best; or no rows."""
    fresh = attempts[(attempts["purpose"] == "confirm") & (attempts["engine"] == engine)]
    drops = failed_drops(attempts, engine)
    lost = fresh[(fresh["who"] == "detector") & fresh["drop"].isin(drops)]
    if lost.empty:
        return lost
    usual = lost["outcome"].mode().iloc[0]
    drop = lost.loc[lost["outcome"] == usual, "drop"].min()
    pair: pd.DataFrame = fresh[fresh["drop"] == drop]
    return pair.sort_values("who")


def _features(
    row: dict[str, Any], attempts: Mapping[str, pd.DataFrame], settings: FailureParameters
) -> dict[str, float]:
    mesh = scaled_surface(row["voxels"], settings)
    found = shape_features(mesh, attempts[row["id"]], settings.gripper)
    return found | {name: row[name] for name in ("complexity", "graspability")}


def _example(
    item: tuple[dict[str, Any], bool],
    attempts: Mapping[str, pd.DataFrame],
    settings: FailureParameters,
) -> Example:
    """Picture and films of a failure; films are left out if not wanted."""
    row, with_films = item
    mesh = scaled_surface(row["voxels"], settings)
    picture = png_bytes(render(mesh, PICTURE))
    rows = film_rows(attempts[row["id"]], settings.failures.engines[0])
    if rows.empty or not with_films:
        return Example(picture)
    tried = rows[rows["pose"].map(len) > 0]
    try:
        films = map(animation, film_attempts(mesh, tried, settings))
    except UserError as reason:
        return Example(picture, note=f"No films: {reason}.")
    contents = dict(zip(tried["who"], films, strict=True))
    return Example(
        picture,
        {
            who: AttemptFilm(outcome, contents.get(who, b""))
            for who, outcome in zip(rows["who"], rows["outcome"], strict=True)
        },
    )


def animation(frames: list[RgbImage]) -> bytes:
    """An animated WebP file of frames, 20 per second, that holds its last frame for a while."""
    *kept, last = [Image.fromarray(frame) for frame in [*frames[:-1:EVERY], frames[-1]]]
    buffer = io.BytesIO()
    (kept or [last])[0].save(
        buffer,
        "webp",
        save_all=True,
        append_images=[*kept[1:], last],
        duration=[*[FRAME_TIME] * max(len(kept), 1), LAST_TIME],
        loop=0,
        quality=QUALITY,
    )
    return buffer.getvalue()


def _feature_shares(failures: pd.DataFrame, solved: pd.DataFrame) -> list[FeatureShare]:
    """Features as shown on the page; those that explain most come first."""
    units = [SHAPE_FEATURES[str(name)].factor for name in failures]
    failures, solved = failures.mul(units), solved.mul(units)
    found = [
        FeatureShare(
            SHAPE_FEATURES[name],
            share,
            *(table[name].dropna().to_numpy(float) for table in (solved, failures)),
        )
        for name, share in shares(failures, solved).items()
    ]
    return sorted(found, key=lambda each: -each.share.value)


def _dataset(examined: pd.DataFrame, objects: Dataset | None) -> pd.DataFrame:
    """The objects that a search began with, as far as known."""
    looked = examined[examined["source"] == "archive"].dropna(subset=["graspability"])
    if objects is None:
        released = load()
        if not looked["id"].isin(released.table["id"]).any() and len(looked):
            return looked
        objects = released
    return objects.table


def _search_text(detector: str, settings: FailureParameters) -> SearchText:
    hand, search, rule = settings.gripper, settings.failures, settings.trials
    closes = rule.contact == "close" or search.approach == "any"
    force = ContactRule().stopping_force if search.approach == "any" else rule.stopping_force
    contact = "the hand stops and closes there" if closes else "the attempt fails"
    size = f"{1000 * hand.opening:g} mm"
    return SearchText(
        detector,
        hand.kind.described(size),
        search.approach or "",
        f"A contact of more than {force:g} N on the way: {contact}",
        search.engines,
        search.least_reference,
        search.least_difference,
        search.confidence,
    )
