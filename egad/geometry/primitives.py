"""Random objects of joined boxes, cylinders and spheres: shapes that nobody selected."""

from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.geometry.manifold import Solid, to_mesh, union

PIECES = (2, 5)  # of an object
SIDES = (0.2, 1.0)  # of a piece, before the object is scaled
SEGMENTS = 48  # of a full turn
DEPTH = 0.2  # of the way from the skin to the middle: where the point that two pieces share lies
# Which of three random sides a piece uses. Pieces with sides of 2 touch the unit ball.
KINDS = {"box": [0, 1, 2], "cylinder": [0, 0, 1], "sphere": [0, 0, 0]}


class Piece(NamedTuple):
    """A primitive and its pose."""

    kind: str  # a key of `KINDS`
    sides: Floats  # along its own axes, (3,)
    rotation: Floats  # from its own axes to those of the object, (3, 3)
    middle: Floats  # (3,)


def joined_primitives(rng: np.random.Generator, longest_side: float) -> trimesh.Trimesh:
    """A random closed body of 2 to 5 primitives about the origin, metres (after Tobin, 2018)."""
    mesh = to_mesh(union(map(solid_of, random_pieces(rng))))
    low, high = mesh.bounds
    mesh.vertices = (mesh.vertices - (low + high) / 2) * (longest_side / (high - low).max())
    return mesh


def random_pieces(rng: np.random.Generator) -> list[Piece]:
    """The pieces of an object, each attached to one before it."""
    pieces = [loose_piece(rng)]
    for _ in range(rng.integers(*PIECES, endpoint=True) - 1):
        pieces.append(attach(loose_piece(rng), pieces[rng.integers(len(pieces))], rng))
    return pieces


def loose_piece(rng: np.random.Generator) -> Piece:
    """A primitive with random sides, turned at random, its middle at the origin."""
    kind = str(rng.choice(list(KINDS)))
    sides = rng.uniform(*SIDES, size=3)[KINDS[kind]]
    return Piece(kind, sides, Rotation.from_quat(rng.normal(size=4)).as_matrix(), np.zeros(3))


def attach(piece: Piece, base: Piece, rng: np.random.Generator) -> Piece:
    """Move a piece so that it overlaps a base a little, and its middle lies further out."""
    outwards, onwards = _below_skin(base, rng), _below_skin(piece, rng)
    away = np.copysign(1.0, outwards @ onwards)  # a piece is the same seen from the other side
    return piece._replace(middle=base.middle + outwards + away * onwards)


def _below_skin(piece: Piece, rng: np.random.Generator) -> Floats:
    """From the middle of a piece to a random point of a smaller ellipsoid within it, (3,)."""
    direction = rng.normal(size=3)
    on_ball = direction / np.linalg.norm(direction)
    return np.asarray(piece.rotation @ (on_ball * piece.sides / 2) * (1 - DEPTH))


def solid_of(piece: Piece) -> Solid:
    """A primitive as a solid in its place."""
    unit = {
        "box": lambda: manifold3d.Manifold.cube((2, 2, 2), True),
        "cylinder": lambda: manifold3d.Manifold.cylinder(2, 1, 1, SEGMENTS, True),
        "sphere": lambda: manifold3d.Manifold.sphere(1, SEGMENTS),
    }[piece.kind]()
    return unit.transform(np.column_stack([piece.rotation * (piece.sides / 2), piece.middle]))
