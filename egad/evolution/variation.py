"""Which genomes are bred next."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.ndimage import convolve

from egad._util.arrays import Floats
from egad.evolution.genome import Row, child, neat_config, random_genome
from egad.evolution.parameters import EvolutionParameters
from egad.measures import MeasureSpace, complexity_cells, difficulty_cells
from egad.random import entropy, generator

MIN_WEIGHT = 0.25  # weight of a parent without empty slots around it: it may still be sampled


class _Parent(Protocol):
    """What may have children: an elite of an archive, with its genome and measures."""

    @property
    def id(self) -> str: ...
    @property
    def genome(self) -> Row: ...
    @property
    def complexity(self) -> float: ...
    @property
    def graspability(self) -> float: ...


@dataclass(frozen=True)
class Offspring:
    """A genome that has not been evaluated, and where it comes from."""

    genome: Row
    parents: tuple[str, ...]


def breed(elites: Sequence[_Parent], settings: EvolutionParameters, *index: int) -> list[Offspring]:
    """The offspring of a step (EGAD, III-D); sparse parents, litters and restarts are ours."""
    config = neat_config(settings.neat)
    rng = generator(settings.seed, "parents", *index)
    drawn = _parents(elites, settings, rng)
    litter = []
    for number, parents in enumerate(drawn):
        seed = entropy(settings.seed, "child", *index, number)
        genome = (
            child(config, [parent.genome for parent in parents], seed)
            if parents
            else random_genome(config, seed)
        )
        litter.append(Offspring(genome, tuple(parent.id for parent in parents)))
    return litter


def _parents(
    elites: Sequence[_Parent], settings: EvolutionParameters, rng: np.random.Generator
) -> list[list[_Parent]]:
    """The parents of each child; none for a random genome."""
    evolution = settings.evolution
    if not elites:
        return [[]] * evolution.population
    chances = None
    if evolution.parents == "sparse":
        chances = np.cumsum(parent_odds(elites, settings.space))
        chances /= chances[-1]
    drawn: list[list[_Parent]] = []
    while len(drawn) < evolution.population:
        parents = [elites[_draw(rng, len(elites), chances)]]
        if rng.random() < evolution.crossover_probability:
            parents.append(elites[_draw(rng, len(elites), chances)])
        if evolution.restart and rng.random() < evolution.restart:
            parents = []
        drawn += [parents] * evolution.siblings
    return drawn[: evolution.population]


def _draw(rng: np.random.Generator, count: int, chances: Floats | None) -> int:
    """A random index below `count`: uniform, or by the running sums of the probabilities."""
    if chances is None:
        return int(rng.integers(count))
    return int(np.searchsorted(chances, rng.random(), side="right"))


def parent_odds(elites: Sequence[_Parent], space: MeasureSpace) -> Floats:
    """The probability of each of n elites to be a parent, (n,), by the empty slots near it."""
    columns = complexity_cells([elite.complexity for elite in elites], space)
    rows = difficulty_cells([elite.graspability for elite in elites], space)
    counts = np.zeros((space.cells, space.cells))
    np.add.at(counts, (rows, columns), 1)
    empty = convolve(space.elites_per_cell - counts, np.ones((3, 3)), mode="constant")
    weights = empty[rows, columns] + MIN_WEIGHT
    return np.asarray(weights / weights.sum())
