import numpy as np
import pytest

from egad.geometry.manifold import to_solid
from egad.geometry.primitives import (
    KINDS,
    Piece,
    attach,
    joined_primitives,
    loose_piece,
    solid_of,
)
from egad.random import generator


def made(number, longest_side=0.1, seed=0):
    return joined_primitives(generator(seed, "primitives", number), longest_side)


@pytest.mark.parametrize("number", range(8))
def test_an_object_is_one_closed_body_of_the_size_asked_for(number):
    mesh = made(number)
    assert mesh.is_volume
    assert len(to_solid(mesh.vertices, mesh.faces).decompose()) == 1
    assert mesh.extents.max() == pytest.approx(0.1)
    assert mesh.bounds.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert 0 < mesh.volume < 0.1**3


def test_the_same_number_is_the_same_object_and_another_one_is_not():
    first, again = made(3), made(3)
    assert first.vertices.tobytes() == again.vertices.tobytes()
    assert first.faces.tobytes() == again.faces.tobytes()
    volumes = {round(made(number, seed=seed).volume, 12) for number in range(15) for seed in (0, 1)}
    assert len(volumes) == 30


@pytest.mark.parametrize(
    ("kind", "volume"), [("box", 1.0), ("cylinder", np.pi / 4), ("sphere", np.pi / 6)]
)
def test_pieces_have_the_volume_of_their_kind(kind, volume):
    sides = np.array([0.5, 0.3, 0.9])[KINDS[kind]]
    turn = loose_piece(np.random.default_rng(0)).rotation
    solid = solid_of(Piece(kind, sides, turn, np.array([1.0, 2.0, 3.0])))
    assert solid.volume() == pytest.approx(volume * sides.prod(), rel=0.02)
    middle = np.reshape(solid.bounding_box(), (2, 3)).mean(axis=0)
    assert middle == pytest.approx(np.array([1.0, 2.0, 3.0]), abs=1e-9)


def test_attached_pieces_overlap_their_base_and_lie_further_out():
    for number in range(80):
        rng = np.random.default_rng(number)
        base = loose_piece(rng)._replace(middle=rng.normal(size=3))
        piece = attach(loose_piece(rng), base, rng)
        both = (solid_of(base) ^ solid_of(piece)).volume()
        assert both > 1e-5
        assert (piece.rotation @ piece.rotation.T) == pytest.approx(np.eye(3))
        nearest = 0.8 * base.sides.min() / 2
        assert np.linalg.norm(piece.middle - base.middle) > nearest
