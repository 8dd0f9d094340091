"""How an offspring is evaluated: its solid, a first estimate of its measures, and a final one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from egad.cppn import Row, Rules, grow, packed_surface, voxels
from egad.errors import RejectedError
from egad.map_elites.archive import Elite
from egad.map_elites.parameters import EvolutionParameters
from egad.measures import Estimate, measure_mesh, rough_difficulty, spaced_difficulty
from egad.measures.difficulty import difficulty
from egad.random import generator
from egad.reeb import graph as reeb


@dataclass(frozen=True)
class GenomeVoxels:
    """The voxels that a genome stands for."""

    id: str
    packed: bytes


@dataclass(frozen=True)
class Measured:
    """The measures of a solid."""

    complexity: float
    difficulty: float
    graph: reeb.ReebGraph


Evaluate = Callable[[GenomeVoxels], Measured | str]


def express(row: Row, settings: EvolutionParameters, rules: Rules) -> GenomeVoxels | str:
    """The solid of a genome, or the reason why it is none that is allowed."""
    shape = settings.shape
    try:
        solid = grow(row, shape.resolution, shape.threshold, rules)
    except RejectedError as error:
        return str(error)
    return GenomeVoxels(voxels.identity(solid), voxels.pack(solid))


def measure(solid: GenomeVoxels, settings: EvolutionParameters) -> Measured | str:
    """The measures of a solid, or the reason why it has none.

    The grasps are sampled with a generator named after the solid, so equal solids have equal
    measures wherever and whenever they are found.
    """
    mesh = packed_surface(solid.packed, settings.shape)
    try:
        place = measure_mesh(mesh, settings, first_estimate(solid.id, settings))
        graph = reeb.extract(mesh, settings.similarity)
    except RejectedError as error:
        return str(error)
    return Measured(place.complexity, place.difficulty, graph)


def first_estimate(solid_id: str, settings: EvolutionParameters) -> Estimate:
    """The paper's estimate of the difficulty of a solid, or a rough one that `refine` replaces."""
    if settings.evolution.estimator == "paper":
        rng = generator(settings.seed, "difficulty", solid_id)
        count = settings.evolution.grasps
        return partial(spaced_difficulty, settings=settings, count=count, rng=rng)
    rng = generator(settings.seed, "first estimate", solid_id)
    return partial(rough_difficulty, settings=settings, rng=rng)


def refine(elite: Elite, settings: EvolutionParameters) -> Elite | None:
    """An object with the final estimate of its difficulty; None if there is no grasp.

    Its grasps are others than those of the first estimate, whose error may be why the archive
    would keep the object.
    """
    mesh = packed_surface(elite.voxels, settings.shape)
    rng = generator(settings.seed, "difficulty", elite.id)
    try:
        found = difficulty(mesh, settings, settings.evolution.max_candidates, rng)
    except RejectedError:
        return None
    return replace(
        elite,
        difficulty=found.value,
        difficulty_std=found.std,
        cell_confidence=found.confidence,
    )
