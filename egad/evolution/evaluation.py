"""How an offspring is evaluated: its solid, a first estimate of its measures, and a final one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from egad.errors import RejectedError
from egad.evolution import voxels
from egad.evolution.archive import Elite
from egad.evolution.constraints import Rules
from egad.evolution.genome import Row
from egad.evolution.growth import grow, packed_surface
from egad.evolution.parameters import EvolutionParameters
from egad.measures import Estimate, measure_mesh, rough_graspability, spaced_graspability
from egad.measures.graspability import graspability
from egad.measures.reeb import graph as reeb
from egad.random import generator


@dataclass(frozen=True)
class GenomeVoxels:
    """The voxels that a genome describes."""

    id: str
    packed: bytes


@dataclass(frozen=True)
class Measured:
    """The measures of a solid."""

    complexity: float
    graspability: float
    graph: reeb.ReebGraph


Evaluate = Callable[[GenomeVoxels], Measured | str]


def express(row: Row, settings: EvolutionParameters, rules: Rules) -> GenomeVoxels | str:
    """The solid of a genome, or the reason why it is not allowed."""
    shape = settings.shape
    try:
        solid = grow(row, shape.resolution, shape.threshold, rules)
    except RejectedError as error:
        return str(error)
    return GenomeVoxels(voxels.identity(solid), voxels.pack(solid))


def measure(solid: GenomeVoxels, settings: EvolutionParameters) -> Measured | str:
    """The measures of a solid, which seeds its grasps, or the reason why it has none."""
    mesh = packed_surface(solid.packed, settings.shape)
    try:
        place = measure_mesh(mesh, settings, first_estimate(solid.id, settings))
        graph = reeb.extract(mesh, settings.similarity)
    except RejectedError as error:
        return str(error)
    return Measured(place.complexity, place.graspability, graph)


def first_estimate(solid_id: str, settings: EvolutionParameters) -> Estimate:
    """The paper's estimate of the graspability of a solid, or one that `refine` replaces."""
    if settings.evolution.estimator == "paper":
        # the purpose is older than the word graspability; another would change all values
        rng = generator(settings.seed, "difficulty", solid_id)
        count = settings.evolution.grasps
        return partial(spaced_graspability, settings=settings, count=count, rng=rng)
    rng = generator(settings.seed, "first estimate", solid_id)
    return partial(rough_graspability, settings=settings, rng=rng)


def refine(elite: Elite, settings: EvolutionParameters) -> Elite | None:
    """An object with the final estimate of its graspability, from other grasps, or None."""
    mesh = packed_surface(elite.voxels, settings.shape)
    rng = generator(settings.seed, "difficulty", elite.id)
    try:
        found = graspability(mesh, settings, settings.evolution.max_candidates, rng)
    except RejectedError:
        return None
    return replace(
        elite,
        graspability=found.value,
        graspability_std=found.std,
        cell_confidence=found.confidence,
    )
