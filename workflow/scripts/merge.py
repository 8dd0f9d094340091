"""merge: combine the islands of an epoch into one archive."""

from pathlib import Path

from egad._util.progress import phase
from egad.evolution import merge
from egad.measures import CellsAndDiversities
from egad.tables import parquet
from egad.tables.evolution import EPOCH
from egad_workflow.job import run_job


def run(settings: CellsAndDiversities, islands: list[Path], archive: Path, jobs: int = 1) -> None:
    """Merge the islands of an epoch into one archive."""
    frames = [parquet.read(path, EPOCH) for path in islands]
    if len(frames) > 1:
        phase(f"merging {len(frames)} islands")
        frames = [merge(frames, settings.space, settings.similarity, jobs)]
    parquet.write(frames[0], EPOCH, archive, parquet.notes(islands[0]))


if __name__ == "__main__":
    run_job(run)
