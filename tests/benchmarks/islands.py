"""Where merging outgrows evolving, for studies/scaling/README.md.

    python tests/benchmarks/islands.py STEPS      islands do so many steps of 100 children, twice
    python tests/benchmarks/islands.py FILE...    archives of epochs, as if they were islands

More and more of them are merged. A line each: CPU seconds of an island and of the merge, different
objects before and after it.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pandas as pd

from egad.evolution import Archive, EvolutionParameters, elites_of, evolve, merge
from egad.tables import parquet
from egad.tables.evolution import EPOCH
from egad_workflow.settings import Settings, select

ISLANDS = (1, 2, 4, 8, 16, 32)
T = TypeVar("T")


def clocked(work: Callable[..., T], *arguments: object) -> tuple[T, float]:
    """What some work returns, and its CPU seconds."""
    start = time.process_time()
    return work(*arguments), time.process_time() - start


def island(
    settings: EvolutionParameters, base: pd.DataFrame | None, epoch: int, number: int
) -> pd.DataFrame:
    """One epoch of one island."""
    archive = Archive(settings.space, settings.similarity)
    if base is not None:
        archive.add(elites_of(base))
    evolve(archive, settings, epoch, number)
    return archive.to_frame()


def epoch(settings: EvolutionParameters, base: pd.DataFrame | None, number: int) -> pd.DataFrame:
    """Print what an epoch costs; returns the archive that all islands are merged to."""
    frames, spent, merged = [], [], pd.DataFrame()
    for count in ISLANDS:
        while len(frames) < count:
            frame, cpu = clocked(island, settings, base, number, len(frames))
            frames.append(frame)
            spent.append(cpu)
        merged = merging(settings, frames[:count], f"{sum(spent) / len(spent):.1f}")
    return merged


def merging(
    settings: EvolutionParameters, frames: list[pd.DataFrame], spent: str = ""
) -> pd.DataFrame:
    """Merge islands and print what it costs, beside what an island has cost."""
    merged, cpu = clocked(merge, frames, settings.space, settings.similarity)
    objects = len({name for frame in frames for name in frame["id"]})
    cells = [str(len(frames)), spent, f"{cpu:.1f}", str(objects), str(len(merged))]
    print("| " + " | ".join(cells) + " |", flush=True)
    return merged


def main(arguments: list[str]) -> None:
    """Print a table."""
    steps = int(arguments[0]) if arguments[0].isdigit() else 1
    settings = select(
        Settings.model_validate({"evolution": {"evaluations": 100 * steps}}), EvolutionParameters
    )
    few = select(Settings.model_validate({"evolution": {"evaluations": 100}}), EvolutionParameters)
    merge([island(few, None, 9, 0), island(few, None, 9, 1)], few.space, few.similarity)  # compiles
    print("| islands | s an island | s the merge | objects | kept |")
    print("| --- | --- | --- | --- | --- |")
    if not arguments[0].isdigit():
        frames = [parquet.read(Path(name), EPOCH) for name in arguments]
        for count in (each for each in ISLANDS if each <= len(frames)):
            merging(settings, frames[:count])
        return
    base = None
    for number in (0, 1):
        base = epoch(settings, base, number)


if __name__ == "__main__":
    main(sys.argv[1:])
