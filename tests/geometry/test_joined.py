import numpy as np
import pytest

from egad.geometry.manifold import to_solid
from egad.geometry.primitives import (
    KINDS,
    Piece,
    attach,
    joined_primitives,
    loose_piece,
    random_pieces,
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


def test_size_changes_nothing_but_the_scale():
    small, large = made(5, 0.05), made(5, 0.2)
    assert np.array_equal(small.faces, large.faces)
    assert 4 * small.vertices == pytest.approx(large.vertices)


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


def test_objects_have_two_to_five_pieces_that_hang_together():
    sets = [random_pieces(np.random.default_rng(number)) for number in range(80)]
    assert {len(pieces) for pieces in sets} == {2, 3, 4, 5}
    for pieces in sets:
        solids = [solid_of(piece) for piece in pieces]
        for number in range(1, len(solids)):
            assert any((solids[number] ^ before).volume() > 0 for before in solids[:number])


def test_all_kinds_and_turns_are_as_likely():
    pieces = [loose_piece(np.random.default_rng(number)) for number in range(600)]
    counts = [sum(piece.kind == kind for piece in pieces) for kind in KINDS]
    assert all(160 < count < 240 for count in counts)  # 3.5 standard deviations
    ups = np.array([piece.rotation[:, 2] for piece in pieces])
    assert np.abs(ups.mean(axis=0)).max() < 0.1
    assert np.abs(ups.T @ ups / len(ups) - np.eye(3) / 3).max() < 0.06
