"""merge: the islands of an epoch become one archive; the last one is published."""

from pathlib import Path

from egad._util.progress import phase
from egad.map_elites.archive import merge
from egad.pipeline.config.stage_settings import Merge
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, EPOCH


def run(settings: Merge, islands: list[Path], out: Path, threads: int = 1) -> None:
    """Merge the archives of all islands (columns of `tables.evolution.EPOCH`)."""
    frames = [parquet.read(path, EPOCH) for path in islands]
    if len(frames) > 1:
        phase(f"merging {len(frames)} islands")
        frames = [merge(frames, settings.space, settings.similarity, threads)]
    parquet.write(frames[0], EPOCH, out, parquet.notes(islands[0]))


def publish(epoch_archive: Path, out: Path) -> None:
    """Write the archive of the last epoch without its internal columns."""
    archive = parquet.read(epoch_archive, ARCHIVE)
    parquet.write(archive, ARCHIVE, out, parquet.notes(epoch_archive))
