import numpy as np
import pytest
import trimesh

from egad.evalset.checks import print_problems, shell_volumes
from egad.evalset.thickness import thinness, thinnest
from egad.settings import PrintCheck

CHECK = PrintCheck(wall=0.0012, blunting=0.0015)


def box(*sides):
    return trimesh.creation.box(extents=0.001 * np.array(sides))


def dumbbell(neck):
    """Two cubes joined by a square bar, millimetres."""
    far = box(20, 20, 20).apply_translation([0.023, 0, 0])
    bar = box(5, neck, neck).apply_translation([0.0115, 0, 0])
    return trimesh.boolean.union([box(20, 20, 20), far, bar], engine="manifold")


@pytest.mark.parametrize("thick", [0.5, 1.0, 1.15, 1.25, 2.0])
def test_a_plate_passes_from_the_thinnest_wall_on(thick):
    wrong = print_problems(box(30, 25, thick), CHECK)
    assert wrong == ([] if thick >= 1.2 else ["walls thinner than 1.2 mm"])


@pytest.mark.parametrize("thick", [1.5, 2.2, 4.0])
def test_the_thickness_of_a_plate_is_measured(thick):
    found = thinnest(box(30, 25, thick), 1.25, (0.001, 0.01), 8)
    assert found == pytest.approx(0.001 * thick, rel=0.03)


def test_a_turned_and_finely_cut_plate_is_as_thin_as_before():
    plate = box(30, 25, 1.1).subdivide().subdivide()
    plate.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1, 2, 3]))
    assert print_problems(plate, CHECK) == ["walls thinner than 1.2 mm"]


def test_edges_and_tips_are_no_walls():
    """A right-angled edge loses 0.21 diameters, a cone's tip (1 / sin(half its angle) - 1) / 2."""
    assert thinness(box(20, 20, 20), 0.0012).reach < 0.0006
    for half, passes in ((45, True), (30, True), (20, True), (8, False)):
        angle = np.radians(half)
        cone = trimesh.creation.cone(radius=0.03 * np.tan(angle), height=0.03, sections=64)
        assert (print_problems(cone, CHECK) == []) == passes


def test_a_ball_is_as_thick_as_it_is_wide():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.004)
    assert thinness(ball, 0.0012).reach == pytest.approx(0, abs=1e-5)
    assert thinnest(ball, 1.25, (0.001, 0.02), 8) == pytest.approx(0.008, rel=0.06)


def test_parts_that_only_hang_together_by_a_thread_are_named():
    assert print_problems(dumbbell(2.0), CHECK) == []
    assert print_problems(dumbbell(1.0), CHECK) == ["parts joined by less than 1.2 mm"]


def test_scaling_down_makes_walls_too_thin():
    plate = box(30, 25, 2)
    assert print_problems(plate, CHECK) == []
    assert print_problems(plate.apply_scale(0.5), CHECK) != []


def test_a_trapped_void_is_found():
    cavity = box(8, 8, 8)
    cavity.invert()
    hollow = trimesh.util.concatenate([box(20, 20, 20), cavity])
    assert shell_volumes(hollow) == pytest.approx([8e-6, -0.512e-6])
    assert print_problems(hollow, CHECK) == ["1 trapped void"]


def test_two_bodies_are_found():
    pair = trimesh.util.concatenate([box(9, 9, 9), box(9, 9, 9).apply_translation([0.02, 0, 0])])
    assert print_problems(pair, CHECK)[0] == "2 bodies"


def test_an_open_surface_is_not_closed():
    cut = box(20, 20, 20)
    cut.update_faces(np.arange(12) > 0)
    assert print_problems(cut, CHECK) == ["not closed"]
