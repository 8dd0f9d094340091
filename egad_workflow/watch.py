"""The live map of a running evolution. It decides no result, so no job depends on this module."""

from pathlib import Path

from egad.evolution import EvolutionParameters, Watch
from egad.report.axes import axis_pair
from egad.report.live_map import EpochOfIsland, LiveMap
from egad_workflow.provenance import settings_hash


def watch_of(
    settings: EvolutionParameters, epoch: int, island: int, page: Path, islands: int | None
) -> Watch:
    """What draws the live map after each step."""
    evaluations = settings.evolution.steps * settings.evolution.population
    about = EpochOfIsland(settings_hash(settings), epoch, island, evaluations, islands)
    names = axis_pair(settings.measures)
    return LiveMap(page, about, settings.space, settings.shape.resolution, names)
