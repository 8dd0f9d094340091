import numpy as np
import pytest

from egad.cppn import constraints, voxels
from egad.cppn.constraints import UNBOUND, Rules, build_rules, with_images
from egad.cppn.parameters import Envelope, Hole, Limits, Part, Symmetry
from egad.errors import RejectedError, UserError

R = 12


def rules(**regions):
    free = {"envelope": Envelope(), "part": Part(), "hole": Hole()}
    free |= {"symmetry": Symmetry(), "limits": Limits()}
    return build_rules(R, lambda path: pytest.fail(f"{path} was read"), **(free | regions))


def noise(seed):
    """A field with bodies of some size."""
    coarse = np.random.default_rng(seed).normal(size=(4, 4, 4))
    return coarse.repeat(3, 0).repeat(3, 1).repeat(3, 2).astype(np.float32)


def solid(field, rules):
    return constraints.solid(field, 0.0, rules)


def test_without_rules_a_solid_is_what_it_was():
    for seed in range(10):
        assert np.array_equal(solid(noise(seed), UNBOUND), voxels.solid(noise(seed), 0.0))
    default = rules()
    assert default.allowed is None
    assert default.part is None


def test_nothing_leaves_the_envelope_nor_enters_the_hole():
    envelope = Envelope(kind="ellipsoid")
    hole = Hole(kind="cylinder", size=(0.3, 0.3, 1))
    bound = rules(envelope=envelope, hole=hole)
    inside = constraints.region_voxels(envelope, R) & ~constraints.region_voxels(hole, R)
    for seed in range(10):
        found = solid(noise(seed), bound)
        assert not (found & ~inside).any()
        assert np.array_equal(found, voxels.largest_body(found))


def test_everything_is_cut_to_the_envelope():
    bound = rules(envelope=Envelope(kind="cylinder", axis="x"))
    full = np.ones((R, R, R), dtype=np.float32)
    found = solid(full, bound)
    assert not (found & ~bound.allowed).any()
    assert found.sum() > 0.9 * bound.allowed.sum()


def test_the_part_is_contained_or_the_shape_rejected():
    bound = rules(part=Part(kind="box", size=(0.2, 0.2, 0.5), centre=(0, 0, -0.25)))
    assert bound.part.sum() == 2 * 2 * 6
    for seed in range(20):
        try:
            found = solid(noise(seed), bound)
        except RejectedError as error:
            assert str(error) == "apart from its part"  # noqa: PT017
        else:
            assert found[bound.part].all()


def test_a_larger_body_apart_from_the_part_is_rejected():
    field = np.full((R, R, R), -1, dtype=np.float32)
    field[7:] = 1
    bound = rules(part=Part(kind="box", size=(0.25, 0.25, 0.25), centre=(-0.375, 0, 0)))
    with pytest.raises(RejectedError, match="apart from its part"):
        solid(field, bound)
    field[3:7, 4:8, 4:8] = 1
    assert solid(field, bound)[bound.part].all()


def test_an_empty_genome_grows_just_the_part():
    bound = rules(part=Part(kind="ellipsoid", size=(0.5, 0.5, 0.5)))
    nothing = np.full((R, R, R), np.nan, dtype=np.float32)
    assert np.array_equal(solid(nothing, bound), bound.part)
    with pytest.raises(RejectedError, match="empty"):
        solid(nothing, UNBOUND)


def test_the_part_may_stick_out_of_the_envelope_but_the_hole_goes_through_it():
    bound = rules(
        envelope=Envelope(kind="box", size=(1, 1, 0.5), centre=(0, 0, 0.25)),
        part=Part(kind="cylinder", size=(0.5, 0.5, 1)),
        hole=Hole(kind="cylinder", size=(0.2, 0.2, 1)),
    )
    full = solid(np.ones((R, R, R), dtype=np.float32), bound)
    assert full[..., 0].any()
    assert not full[6, 6].any()
    assert full[bound.part].all()
    assert not (full & ~bound.allowed).any()


def test_a_hole_must_not_be_closed_in():
    full = np.ones((R, R, R), dtype=np.float32)
    hole = {"kind": "ellipsoid", "size": (0.4, 0.4, 0.4)}
    with pytest.raises(RejectedError, match="closed around"):
        solid(full, rules(hole=Hole(**hole)))
    at_the_side = solid(full, rules(hole=Hole(**hole, centre=(0.4, 0, 0))))
    assert at_the_side.any()


def test_mirrors_hold_for_regions_too():
    bound = rules(
        part=Part(kind="box", size=(0.25, 0.25, 0.25), centre=(0.3, 0, 0)),
        envelope=Envelope(kind="box", size=(1, 0.5, 1), centre=(0, 0.1, 0)),
        symmetry=Symmetry(mirror=("x", "y")),
    )
    for grid in (bound.part, bound.allowed):
        assert np.array_equal(grid, with_images(grid, ("x", "y")))
    assert bound.allowed.sum() < R * R * R / 2


@pytest.mark.parametrize(
    ("limits", "word"),
    [
        (Limits(aspect_ratio=(1, 1.5)), "aspect ratio"),
        (Limits(aspect_ratio=(5, 9)), "aspect ratio"),
        (Limits(box_part=(0, 0.5)), "part of its box"),
        (Limits(cube_part=(0.2, 1)), "part of the cube"),
    ],
)
def test_shapes_out_of_the_limits_are_rejected_with_the_value(limits, word):
    bar = np.full((R, R, R), -1, dtype=np.float32)
    bar[:, 3:8, 3:8] = 1
    found = solid(bar, UNBOUND)
    with pytest.raises(RejectedError, match=rf"{word} out of limits \(.+\)"):
        solid(bar, Rules(limits=limits))
    wide = Limits(aspect_ratio=(2, 2.5), box_part=(0.6, 1), cube_part=(0, 0.18))
    assert np.array_equal(solid(bar, Rules(limits=wide)), found)


def test_a_shape_right_at_its_limits_is_within_them():
    bar = np.full((R, R, R), -1, dtype=np.float32)
    bar[:, 3:9, 3:9] = 1
    found = solid(bar, UNBOUND)
    box, cube = found.sum() / (12 * 6 * 6), found.sum() / R**3
    for limits in (
        Limits(aspect_ratio=(2, 9), box_part=(box, 1), cube_part=(cube, 1)),
        Limits(aspect_ratio=(1, 2), box_part=(0, box), cube_part=(0, cube)),
    ):
        assert np.array_equal(solid(bar, Rules(limits=limits)), found)


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ({"hole": Hole(kind="box")}, "no voxel of the cube to grow in"),
        (
            {"part": Part(kind="ellipsoid", size=(0.4, 0.4, 0.4)), "hole": Hole(kind="box")},
            "outside the hole",
        ),
        (
            {"envelope": Envelope(kind="box", size=(0.01, 1, 1), centre=(0.5, 0, 0))},
            "no voxel of the cube to grow in",
        ),
    ],
)
def test_rules_that_allow_nothing_are_the_users_mistake(sections, words):
    with pytest.raises(UserError, match=words):
        rules(**sections)
