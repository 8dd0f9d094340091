"""release-card: files that explain a dataset release, for people and for programs."""

import fnmatch
import json
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

import pandas as pd
import pyarrow as pa

from egad import __version__
from egad._util.files import atomic_output, write_text
from egad.detectors import NETWORKS
from egad.errors import UserError
from egad.exchange.release import (
    CONTENTS,
    ReleaseCard,
    ReleaseFacts,
    card_page,
    citation_cff,
    licence_text,
)
from egad.io import files_of
from egad.tables import parquet
from egad.tables.release import RELEASED_GRASPS, RELEASED_OBJECTS
from egad_workflow.job import run_job
from egad_workflow.provenance import provenance_graph

PROGRAM = f"egad {__version__}"


def run(
    settings: ReleaseCard, pieces: list[Path], archives: list[Path], gallery: list[Path], out: Path
) -> None:
    """Write the card of a release, its licence, citation, provenance and checksums."""
    _check_archives(out, archives)
    with atomic_output(out / "networks") as folder:
        shutil.copytree(NETWORKS, folder)
    release = settings.release
    objects = parquet.read(out / "data/objects.parquet", RELEASED_OBJECTS)
    listed = [row for row in _contents(out) if row[2]]
    page = card_page(_facts(settings, objects), objects, _success(out), listed)
    write_text(out / "README.md", page)
    citation = citation_cff(release.title, release.version, release.date, release.url)
    write_text(out / "CITATION.cff", citation)
    write_text(out / "LICENSE", licence_text(release.title, release.version))
    graph = {"program": PROGRAM, "files": provenance_graph([*pieces, *archives, *gallery], out)}
    write_text(out / "provenance.json", json.dumps(graph, indent=1, sort_keys=True) + "\n")


def _check_archives(out: Path, pieces: Iterable[Path]) -> None:
    """Raise UserError if there are archives other than those of this release."""
    made = {path.resolve() for path in pieces}
    old = [path for path in sorted(out.glob("archives/*.zip")) if path.resolve() not in made]
    if old:
        raise UserError(
            f"{', '.join(map(str, old))}: from an earlier release; remove it, or add its format to "
            "release.archives"
        )


def _facts(settings: ReleaseCard, objects: pd.DataFrame) -> ReleaseFacts:
    engines = objects["simulated_engine"].dropna().unique()
    return ReleaseFacts(
        title=f"{settings.release.title}, version {settings.release.version}",
        gripper=settings.release.gripper,
        opening=float(objects["opening"].max()),
        density=settings.material.density,
        friction=settings.quality.friction,
        grasps=settings.release.grasps,
        engine=" and ".join(sorted(engines)),
        program=PROGRAM,
    )


def _success(out: Path) -> dict[str, float]:
    """The share of the grasps with an outcome that held, by split."""
    schema = pa.schema([RELEASED_GRASPS.field(name) for name in ("split", "simulated_success")])
    judged = parquet.read(out / "data/grasps.parquet", schema).dropna()
    shares = judged["simulated_success"].astype(bool).groupby(judged["split"]).mean()
    return {str(split): float(share) for split, share in shares.items()}


def _contents(out: Path) -> Iterator[tuple[str, str, int, int]]:
    """The pattern, meaning, number and bytes of the files of a release."""
    paths = {path.relative_to(out).as_posix(): path for path in files_of(out)}
    for pattern, meaning in CONTENTS.items():
        sizes = [paths[name].stat().st_size for name in fnmatch.filter(paths, pattern)]
        yield pattern, meaning, len(sizes), sum(sizes)


if __name__ == "__main__":
    run_job(run)
