"""Genome -> solid -> its coordinates in the space: what one evaluation of evolution does."""

from dataclasses import dataclass

from egad.errors import RejectedError
from egad.measures import reeb
from egad.measures.complexity import complexity
from egad.measures.difficulty import difficulty
from egad.seeds import generator
from egad.shapes import cppn, voxels
from egad.shapes.genome import Row
from egad.shapes.surface import surface
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


def express(row: Row, settings: Evolve) -> Solid | None:
    """The solid of a genome; None if nothing is solid."""
    shape = settings.shape
    solid = voxels.solid(cppn.query(row, shape.resolution), shape.threshold)
    return Solid(voxels.identity(solid), voxels.pack(solid)) if solid.any() else None


def measure(solid: Solid, settings: Evolve) -> Measured | str:
    """The measures of a solid, or the reason why it has none.

    The grasps are drawn from a generator named after the solid, so equal solids have equal
    measures wherever and whenever they are found.
    """
    mesh = surface(voxels.unpack(solid.packed, settings.shape.resolution), settings.shape)
    try:
        quality, _ = difficulty(
            mesh,
            opening=settings.gripper.opening,
            grasps=settings.difficulty.grasps,
            settings=settings.difficulty,
            sampling=settings.sampling,
            quality=settings.quality,
            rng=generator(settings.seed, "difficulty", solid.id),
        )
        entropy = complexity(mesh, settings.complexity.bins)
        return Measured(entropy, quality, reeb.extract(mesh, settings.similarity))
    except RejectedError as error:
        return str(error)
