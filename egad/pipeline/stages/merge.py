"""merge: combine the islands of an epoch into one archive; publish the last one."""

from pathlib import Path
from typing import Annotated

import typer

from egad._util.progress import phase
from egad.map_elites import merge
from egad.pipeline.config import Similarity, Space
from egad.pipeline.config.stage_settings import StageSettings
from egad.pipeline.parameters import Input, Jobs, Output, command
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, EPOCH


class Merge(StageSettings):
    """What merging reads."""

    space: Space
    similarity: Similarity


@command()
def run(
    settings: Merge,
    islands: Annotated[list[Path], typer.Argument(), Input()],
    out: Annotated[Path, Output(schema=EPOCH)],
    jobs: Jobs = 1,
) -> None:
    """Merge the islands of an epoch into one archive.

    Args:
        settings: Settings of this stage.
        islands: Archives of all islands.
        out: Merged archive.
        jobs: Threads; the result does not depend on it.
    """
    frames = [parquet.read(path, EPOCH) for path in islands]
    if len(frames) > 1:
        phase(f"merging {len(frames)} islands")
        frames = [merge(frames, settings.space, settings.similarity, jobs)]
    parquet.write(frames[0], EPOCH, out, parquet.notes(islands[0]))


@command("archive")
def publish(
    epoch_archive: Annotated[Path, typer.Argument(), Input()],
    out: Annotated[Path, Output("D/archive.parquet", ARCHIVE)],
) -> None:
    """Publish the archive of the last epoch.

    Args:
        epoch_archive: Archive of the last epoch; its internal columns are omitted.
        out: The elites of evolution, one per row.
    """
    archive = parquet.read(epoch_archive, ARCHIVE)
    parquet.write(archive, ARCHIVE, out, parquet.notes(epoch_archive))
