"""Genome -> solid -> its coordinates in the space: what one evaluation of evolution does."""

from dataclasses import dataclass

from egad.errors import RejectedError
from egad.measures import reeb
from egad.measures.coordinates import coordinates
from egad.seeds import generator
from egad.shapes import constraints, cppn, voxels
from egad.shapes.genome import Row
from egad.shapes.surface import packed_surface
from egad.stage_settings import Evolve


@dataclass(frozen=True)
class Solid:
    """The voxels that a genome stands for."""

    id: str
    packed: bytes


@dataclass(frozen=True)
class Measured:
    """The measures of a solid."""

    complexity: float
    difficulty: float
    graph: reeb.ReebGraph


def express(row: Row, settings: Evolve, rules: constraints.Rules) -> Solid | str:
    """The solid of a genome, or the reason why it is none that is allowed."""
    shape = settings.shape
    output = cppn.query(row, shape.resolution, rules.symmetry)
    try:
        solid = constraints.solid(output, shape.threshold, rules)
    except RejectedError as error:
        return str(error)
    return Solid(voxels.identity(solid), voxels.pack(solid))


def measure(solid: Solid, settings: Evolve) -> Measured | str:
    """The measures of a solid, or the reason why it has none.

    The grasps are drawn from a generator named after the solid, so equal solids have equal
    measures wherever and whenever they are found, but for newcomers that are graded again.
    """
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "difficulty", solid.id)
    try:
        place = coordinates(mesh, settings, settings.difficulty.grasps, rng)
        graph = reeb.extract(mesh, settings.similarity)
        return Measured(place.complexity, place.difficulty, graph)
    except RejectedError as error:
        return str(error)


def regrade(solid: Solid, settings: Evolve) -> float | str:
    """The difficulty of a solid by other grasps, or the reason why it has none."""
    mesh = packed_surface(solid.packed, settings.shape)
    rng = generator(settings.seed, "newcomer", solid.id)
    try:
        return coordinates(mesh, settings, settings.evolution.regrade, rng).difficulty
    except RejectedError as error:
        return str(error)
