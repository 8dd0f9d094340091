"""Which genomes are bred next."""

from collections.abc import Sequence
from dataclasses import dataclass

from egad.evolution.archive import Elite
from egad.seeds import entropy, generator
from egad.shapes.genome import Row, child, neat_config, random_genome
from egad.stage_settings import Evolve


@dataclass(frozen=True)
class Offspring:
    """A genome that has not been evaluated, and where it comes from."""

    genome: Row
    parents: tuple[str, ...]


def breed(elites: Sequence[Elite], settings: Evolve, *index: int) -> list[Offspring]:
    """The offspring of one step.

    Parents are drawn uniformly from the whole archive; a second one with the crossover
    probability. Without any elites the offspring are random genomes (EGAD, section III-D).

    Args:
        elites: The archive, in a fixed order.
        settings: Population, crossover and mutation.
        *index: Names the step: epoch, island, step. Every child has its own random stream.
    """
    config = neat_config(settings.neat)
    rng = generator(settings.seed, "parents", *index)
    litter = []
    for number in range(settings.evolution.population):
        seed = entropy(settings.seed, "child", *index, number)
        parents: list[Elite] = []
        if elites:
            parents.append(elites[int(rng.integers(len(elites)))])
            if rng.random() < settings.evolution.crossover_probability:
                parents.append(elites[int(rng.integers(len(elites)))])
        genome = (
            child(config, [parent.genome for parent in parents], seed)
            if parents
            else random_genome(config, seed)
        )
        litter.append(Offspring(genome, tuple(parent.id for parent in parents)))
    return litter
