"""merge: the islands of an epoch become one archive; the last one is published."""

from pathlib import Path

from egad import tables
from egad.evolution.archive import merge
from egad.stage_settings import Merge


def run(settings: Merge, islands: list[Path], out: Path) -> None:
    """Merge the archives of all islands (columns of `egad.tables.EPOCH`)."""
    frames = [tables.read(path, tables.EPOCH) for path in islands]
    merged = merge(frames, settings.space, settings.similarity) if len(frames) > 1 else frames[0]
    tables.write(merged, tables.EPOCH, out, tables.notes(islands[0]))


def publish(epoch_archive: Path, out: Path) -> None:
    """Write the archive of the last epoch without its internal columns."""
    archive = tables.read(epoch_archive, tables.ARCHIVE)
    tables.write(archive, tables.ARCHIVE, out, tables.notes(epoch_archive))
