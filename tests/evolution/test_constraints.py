import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError, UserError
from egad.evolution import (
    UNBOUND,
    Envelope,
    Hole,
    KeepSolid,
    Limits,
    Rules,
    Symmetry,
    constraints,
    evolution_parameters,
    voxels,
)
from egad.evolution.constraints import region_voxels, rules_of, with_images
from egad.evolution.parameters import Region

R = 12


def rules(**regions):
    return rules_of(evolution_parameters(0).model_copy(update=regions), R)


def noise(seed):
    """A field with bodies of some size."""
    coarse = np.random.default_rng(seed).normal(size=(4, 4, 4))
    return coarse.repeat(3, 0).repeat(3, 1).repeat(3, 2).astype(np.float32)


def solid(field, rules):
    return constraints.solid(field, 0.0, rules)


def test_a_solid_has_no_thin_sheets_and_nothing_that_is_not_a_number():
    field = np.full((9, 9, 9), -1.0, np.float32)
    field[2:7, 2:7, 2:7] = 1.0
    field[:, 8, :] = 1.0  # one voxel thin
    field[2, 4, 4] = np.nan  # in the middle of a face
    found = solid(field, UNBOUND)
    assert found[4, 4, 4]
    assert not found[2, 4, 4]
    assert not found[:, 8, :].any()


def test_nothing_solid_is_rejected():
    with pytest.raises(RejectedError, match="empty"):
        solid(np.full((9, 9, 9), -1.0, np.float32), UNBOUND)


def test_nothing_leaves_the_envelope_nor_enters_the_hole():
    envelope = Envelope(kind="ellipsoid")
    hole = Hole(kind="cylinder", size=(0.3, 0.3, 1))
    bound = rules(envelope=envelope, hole=hole)
    inside = constraints.region_voxels(envelope, R) & ~constraints.region_voxels(hole, R)
    for seed in range(10):
        found = solid(noise(seed), bound)
        assert not (found & ~inside).any()
        assert np.array_equal(found, voxels.largest_body(found))


def test_the_part_is_contained_or_the_shape_rejected():
    bound = rules(keep_solid=KeepSolid(kind="box", size=(0.2, 0.2, 0.5), center=(0, 0, -0.25)))
    assert bound.required.sum() == 2 * 2 * 6
    for seed in range(20):
        try:
            found = solid(noise(seed), bound)
        except RejectedError as error:
            assert str(error) == "does not contain all of keep_solid"  # noqa: PT017
        else:
            assert found[bound.required].all()


def test_a_larger_body_apart_from_the_part_is_rejected():
    field = np.full((R, R, R), -1, dtype=np.float32)
    field[7:] = 1
    bound = rules(keep_solid=KeepSolid(kind="box", size=(0.25, 0.25, 0.25), center=(-0.375, 0, 0)))
    with pytest.raises(RejectedError, match="does not contain all of keep_solid"):
        solid(field, bound)
    field[3:7, 4:8, 4:8] = 1
    assert solid(field, bound)[bound.required].all()


def test_an_empty_genome_grows_just_the_part():
    bound = rules(keep_solid=KeepSolid(kind="ellipsoid", size=(0.5, 0.5, 0.5)))
    nothing = np.full((R, R, R), np.nan, dtype=np.float32)
    assert np.array_equal(solid(nothing, bound), bound.required)
    with pytest.raises(RejectedError, match="empty"):
        solid(nothing, UNBOUND)


def test_the_part_may_stick_out_of_the_envelope_but_the_hole_goes_through_it():
    bound = rules(
        envelope=Envelope(kind="box", size=(1, 1, 0.5), center=(0, 0, 0.25)),
        keep_solid=KeepSolid(kind="cylinder", size=(0.5, 0.5, 1)),
        hole=Hole(kind="cylinder", size=(0.2, 0.2, 1)),
    )
    full = solid(np.ones((R, R, R), dtype=np.float32), bound)
    assert full[..., 0].any()
    assert not full[6, 6].any()
    assert full[bound.required].all()
    assert not (full & ~bound.allowed).any()


def test_a_hole_must_not_be_closed_in():
    full = np.ones((R, R, R), dtype=np.float32)
    hole = {"kind": "ellipsoid", "size": (0.4, 0.4, 0.4)}
    with pytest.raises(RejectedError, match="encloses space"):
        solid(full, rules(hole=Hole(**hole)))
    at_the_side = solid(full, rules(hole=Hole(**hole, center=(0.4, 0, 0))))
    assert at_the_side.any()


def test_mirrors_hold_for_regions_too():
    bound = rules(
        keep_solid=KeepSolid(kind="box", size=(0.25, 0.25, 0.25), center=(0.3, 0, 0)),
        envelope=Envelope(kind="box", size=(1, 0.5, 1), center=(0, 0.1, 0)),
        symmetry=Symmetry(mirror=("x", "y")),
    )
    for grid in (bound.required, bound.allowed):
        assert np.array_equal(grid, with_images(grid, ("x", "y")))
    assert bound.allowed.sum() < R * R * R / 2


@pytest.mark.parametrize(
    ("limits", "word"),
    [
        (Limits(aspect_ratio=(1, 1.5)), "aspect ratio"),
        (Limits(aspect_ratio=(5, 9)), "aspect ratio"),
        (Limits(box_fraction=(0, 0.5)), "fraction of its box"),
        (Limits(cube_fraction=(0.2, 1)), "fraction of the cube"),
    ],
)
def test_shapes_out_of_the_limits_are_rejected_with_the_value(limits, word):
    bar = np.full((R, R, R), -1, dtype=np.float32)
    bar[:, 3:8, 3:8] = 1
    found = solid(bar, UNBOUND)
    with pytest.raises(RejectedError, match=rf"{word} outside its limits \(.+\)"):
        solid(bar, Rules(limits=limits))
    wide = Limits(aspect_ratio=(2, 2.5), box_fraction=(0.6, 1), cube_fraction=(0, 0.18))
    assert np.array_equal(solid(bar, Rules(limits=wide)), found)


def test_a_shape_right_at_its_limits_is_within_them():
    bar = np.full((R, R, R), -1, dtype=np.float32)
    bar[:, 3:9, 3:9] = 1
    found = solid(bar, UNBOUND)
    box, cube = found.sum() / (12 * 6 * 6), found.sum() / R**3
    for limits in (
        Limits(aspect_ratio=(2, 9), box_fraction=(box, 1), cube_fraction=(cube, 1)),
        Limits(aspect_ratio=(1, 2), box_fraction=(0, box), cube_fraction=(0, cube)),
    ):
        assert np.array_equal(solid(bar, Rules(limits=limits)), found)


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ({"hole": Hole(kind="box")}, "no voxel free for growth"),
        (
            {
                "keep_solid": KeepSolid(kind="ellipsoid", size=(0.4, 0.4, 0.4)),
                "hole": Hole(kind="box"),
            },
            "inside the hole",
        ),
    ],
)
def test_rules_that_allow_nothing_are_the_users_mistake(sections, words):
    with pytest.raises(UserError, match=words):
        rules(**sections)


def made(resolution=20, mesh=None, **values):
    return region_voxels(Region(**values), resolution, mesh)


@pytest.mark.parametrize(
    ("kind", "part"), [("box", 1), ("cylinder", np.pi / 4), ("ellipsoid", np.pi / 6)]
)
def test_volumes_are_those_of_the_bodies(kind, part):
    voxels = made(kind=kind, size=(0.8, 0.5, 0.6), resolution=60)
    assert voxels.mean() == pytest.approx(part * 0.8 * 0.5 * 0.6, rel=0.02)


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
def test_bodies_fill_their_box_and_lie_where_they_should(kind):
    voxels = made(kind=kind, size=(0.5, 0.3, 0.4), center=(0.25, 0, -0.1), axis="y")
    places = np.argwhere(voxels)
    assert places.min(axis=0).tolist() == [10, 7, 4]
    assert places.max(axis=0).tolist() == [19, 12, 11]


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
def test_a_mesh_of_a_body_has_the_voxels_of_the_body(kind):
    meshes = {
        "box": trimesh.creation.box(),
        "cylinder": trimesh.creation.cylinder(0.5, 1, sections=256),
        "ellipsoid": trimesh.creation.icosphere(5, 0.5),
    }
    size = np.array([0.73, 0.51, 0.62])
    mesh = meshes[kind].apply_scale(70 * size).apply_translation([1, -40, 8])
    place = {"size": tuple(size), "center": (0.07, -0.11, 0.03)}
    of_mesh = region_voxels(Region(kind="mesh", mesh="file", **place), 31, mesh)
    of_body = region_voxels(Region(kind=kind, **place), 31)
    assert (of_mesh != of_body).sum() < 0.01 * of_body.sum()


def test_a_mesh_keeps_its_proportions():
    mesh = trimesh.creation.box((1.1, 2, 4))
    voxels = region_voxels(Region(kind="mesh", mesh="file"), 20, mesh)
    assert np.ptp(np.argwhere(voxels), axis=0).tolist() == [5, 9, 19]


def test_a_mesh_that_was_not_read_is_named():
    with pytest.raises(UserError, match=r"part\.stl"):
        region_voxels(Region(kind="mesh", mesh="part.stl"), 8)
