"""One epoch of an island: breed, evaluate side by side, keep the elites."""

import logging
from collections import Counter
from functools import partial

from egad.evolution.archive import Archive, Elite
from egad.evolution.evaluation import Measured, Solid, express, measure
from egad.evolution.reproduction import Offspring, breed
from egad.progress import progress
from egad.shapes.constraints import UNBOUND, Rules
from egad.stage_settings import Evolve
from egad.workers import Mapper

log = logging.getLogger(__name__)


def evolve(
    archive: Archive,
    settings: Evolve,
    epoch: int,
    island: int,
    rules: Rules = UNBOUND,
    mapper: Mapper = map,
) -> Counter[str]:
    """Run the steps of one epoch of one island on its archive.

    Args:
        archive: Changed in place.
        settings: Everything about breeding and measuring.
        epoch: Number of the epoch.
        island: Number of the island.
        rules: What every shape must obey.
        mapper: An order-keeping `map`; where it runs does not change the result.

    Returns:
        How many offspring were evaluated, empty, known already, or rejected for which reason.
    """
    counts: Counter[str] = Counter()
    steps = settings.evolution.steps_per_epoch
    for step in progress(range(steps), f"epoch {epoch}, island {island}", steps):
        offspring = breed(archive.elites, settings, epoch, island, step)
        archive.add(_evaluated(offspring, archive, settings, epoch, rules, mapper, counts))
        log.info("step %d: %d elites, coverage %.3f", step, len(archive), archive.coverage)
    return counts


def _evaluated(
    offspring: list[Offspring],
    archive: Archive,
    settings: Evolve,
    epoch: int,
    rules: Rules,
    mapper: Mapper,
    counts: Counter[str],
) -> list[Elite]:
    """The offspring that are new and can be measured."""
    work = partial(express, settings=settings, rules=rules)
    solids = mapper(work, [each.genome for each in offspring])
    fresh: dict[str, tuple[Offspring, Solid]] = {}
    for each, solid in zip(offspring, solids, strict=True):
        if isinstance(solid, str):
            counts[_kind(solid)] += 1
        elif solid.id in archive or solid.id in fresh:
            counts["known already"] += 1
        else:
            fresh[solid.id] = each, solid
    results = mapper(partial(measure, settings=settings), [solid for _, solid in fresh.values()])
    elites = []
    for (each, solid), result in zip(fresh.values(), results, strict=True):
        if isinstance(result, Measured):
            counts["evaluated"] += 1
            elites.append(_elite(each, solid, result, epoch))
        else:
            counts[_kind(result)] += 1
    return elites


def _kind(reason: str) -> str:
    """A reason without its numbers."""
    return reason.partition(" (")[0]


def _elite(offspring: Offspring, solid: Solid, measured: Measured, epoch: int) -> Elite:
    return Elite(
        id=solid.id,
        genome=offspring.genome,
        voxels=solid.packed,
        complexity=measured.complexity,
        difficulty=measured.difficulty,
        graph=measured.graph,
        parents=offspring.parents,
        epoch=epoch,
    )
