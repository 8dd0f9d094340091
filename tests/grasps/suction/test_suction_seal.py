import numpy as np
import pytest
import trimesh
from cup_shapes import DOWN, box, cylinder, from_above, sphere
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from egad.errors import UserError
from egad.geometry import RayCaster
from egad.grasps.suction import ring_vertices, seal_cups
from egad.grasps.suction.seal import SealFailure, spring_lengths
from egad.grippers import SuctionCup

CUP = SuctionCup()
STANDOFF = 0.001  # of GraspGen's frames
PLATE = trimesh.creation.annulus(r_min=0.21 * CUP.radius, r_max=0.06, height=0.02, sections=256)


def seal(mesh, points):
    caster, origins, frames = from_above(mesh, points)
    return seal_cups(caster, CUP, origins, frames)


def slow_springs(cup, depth, apex):
    """Springs of one cup as end points in space: a list of (kind, length, rest length).

    Args:
        cup: The cup.
        depth: Function from x and y to the depth of the surface.
        apex: Function from the depths of the ring to the depth of the apex.
    """
    n, r, h = cup.sides, cup.radius, cup.height
    corners = [
        (r * np.cos(2 * np.pi * i / n), r * np.sin(2 * np.pi * i / n)) for i in range(cup.sides)
    ]
    ring = [np.array([x, y, depth(x, y)]) for x, y in corners]
    top = np.array([0, 0, apex([z for _, _, z in ring])])
    springs = []
    for i in range(n):
        for kind, other, rest in (
            ("perimeter", ring[(i + 1) % n], 2 * r * np.sin(np.pi / n)),
            ("flexion", ring[(i + 2) % n], 2 * r * np.sin(2 * np.pi / n)),
            ("cone", top, np.sqrt(r**2 + h**2)),
        ):
            springs.append((kind, float(np.linalg.norm(ring[i] - other)), rest))
    return springs


def our_apex(depths):
    return np.mean(depths) - CUP.height


def graspgen_apex(depths):
    """At the mean depth above the frame, not below: the cone is too long by twice that depth."""
    return -(np.mean(depths) + CUP.height)


def strain(springs):
    return max(abs(length / rest - 1) for _, length, rest in springs)


def graspgen_strain(depth):
    return strain(slow_springs(CUP, lambda x, y: depth(x, y) + STANDOFF, graspgen_apex))


def depth_of_sphere(radius):
    return lambda x, y: radius - np.sqrt(radius**2 - x**2 - y**2)


def depth_of_cylinder(radius):
    return lambda x, _: radius - np.sqrt(radius**2 - x**2)


def test_springs_at_rest_have_the_lengths_of_the_reference():
    springs = spring_lengths(CUP, np.zeros((1, 15)))
    for lengths, expected in zip(springs, (6.23735, 12.20210, 33.54102), strict=True):
        assert_allclose(1000 * lengths, expected, atol=5e-6)
    ring = ring_vertices(CUP)
    assert_allclose(np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1), springs.perimeter[0])
    assert_allclose(np.linalg.norm(ring - np.roll(ring, -2, axis=0), axis=1), springs.flexion[0])


def test_springs_agree_with_end_points_in_space():
    depth = depth_of_cylinder(0.03)
    ring = np.array([[depth(x, y) for x, y in ring_vertices(CUP)]])
    found = spring_lengths(CUP, ring)._asdict()
    for kind, lengths in found.items():
        expected = [s[1] for s in slow_springs(CUP, depth, our_apex) if s[0] == kind]
        assert_allclose(lengths[0], expected, rtol=1e-12)


def test_a_box_is_sealed_as_far_as_its_face_reaches():
    found = seal(box(), [[x, 0] for x in (0, 0.01, 0.0149, 0.0151)])
    assert found.sealed.tolist() == [True, True, True, False]
    assert found.failures[3] == SealFailure.MISSED
    assert_allclose(found.strains, [0, 0, 0, np.inf], atol=1e-9)
    assert_allclose(found.depths, [0, 0, 0, np.inf], atol=1e-12)


@pytest.mark.parametrize("radius", [0.13, 0.14, 0.05, 0.02])
def test_spheres_seal_with_the_cone_at_rest(radius):
    """All of the ring is equally deep."""
    found = seal(sphere(radius), [[0, 0]])
    assert found.sealed.all()
    assert found.strains[0] < 2e-3  # the facets of the mesh
    assert strain(slow_springs(CUP, depth_of_sphere(radius), our_apex)) < 1e-12


def test_the_wall_stays_clear_of_spheres_above_a_radius():
    """The sphere leaves the ring less steeply than the wall if R^2 > r^2 (1 + r^2 / h^2)."""
    least = CUP.radius * np.sqrt(1 + (CUP.radius / CUP.height) ** 2)
    assert least == pytest.approx(0.01677, abs=1e-5)
    assert seal(sphere(1.02 * least), [[0, 0]]).sealed.all()
    # close to the radius of the ring, points of the sphere are above the wall that are looked at
    assert seal(sphere(1.004 * CUP.radius), [[0, 0]]).failures[0] == SealFailure.WALL


def test_cylinders_bend_the_cup_as_the_formula_says():
    for radius in (0.016, 0.02, 0.08, 0.1):
        expected = strain(slow_springs(CUP, depth_of_cylinder(radius), our_apex))
        found = seal(cylinder(radius), [[0, 0]])
        assert found.strains[0] == pytest.approx(expected, abs=1e-3)
        assert found.sealed[0] == (expected < CUP.max_strain)
    assert seal(cylinder(0.016), [[0, 0]]).failures[0] == SealFailure.STRAINED


def test_the_rule_of_graspgen_gives_its_published_results():
    flat = slow_springs(CUP, lambda *_: STANDOFF, graspgen_apex)
    assert 1000 * flat[2][1] == pytest.approx(35.341, abs=5e-4)
    assert graspgen_strain(lambda *_: 0.0) < 0.1
    accepted = {
        "spheres": [graspgen_strain(depth_of_sphere(radius)) < 0.1 for radius in (0.13, 0.14)],
        "cylinders": [graspgen_strain(depth_of_cylinder(radius)) < 0.1 for radius in (0.08, 0.1)],
    }
    assert accepted == {"spheres": [False, True], "cylinders": [False, True]}
    ours = [seal(sphere(0.13), [[0, 0]]), seal(cylinder(0.08), [[0, 0]])]
    assert all(each.sealed.all() for each in ours)


def test_a_tilted_plane_strains_the_cone_first():
    """The cone changes by 10 % at tan(angle) = 0.2475: 13.9 degrees."""
    angles = np.radians([0, 8, 13.5, 14.3, 20])
    frames = np.array([Rotation.from_euler("y", a).apply(DOWN) for a in angles])
    origins = np.tile([0, 0, 0.5], (len(angles), 1))
    found = seal_cups(RayCaster(box(1.0)), CUP, origins, frames)
    assert found.sealed.tolist() == [True, True, True, False, False]
    expected = [
        strain(slow_springs(CUP, lambda x, _, a=a: -x * np.tan(a), our_apex)) for a in angles
    ]
    assert_allclose(found.strains, expected, atol=1e-9)


def test_a_hole_inside_the_ring_breaks_the_seal():
    plate = trimesh.creation.annulus(r_min=0.005, r_max=0.04, height=0.02, sections=64)
    found = seal(plate, [[0.0225, 0], [0, 0.0225]])
    assert found.sealed.all()
    origins, frames = np.array([[0, 0, 0.01]]), DOWN[None]
    over = seal_cups(RayCaster(plate), CUP, origins, frames)
    assert over.failures.tolist() == [SealFailure.HOLE.value]
    assert over.strains[0] < 1e-9
    for height, sealed in ((0.02, True), (0.05, False)):  # of the wall around a blind hole
        ring = trimesh.creation.annulus(r_min=0.005, r_max=0.04, height=height, sections=64)
        floor = trimesh.creation.cylinder(0.04, 0.01, sections=64)
        floor.apply_translation([0, 0, -height / 2 - 0.005])
        mesh = trimesh.util.concatenate([ring, floor])
        blind = seal_cups(RayCaster(mesh), CUP, np.array([[0, 0, height / 2]]), frames)
        assert blind.sealed.tolist() == [sealed]


@pytest.mark.parametrize("x", [0, 0.003, 0.006, 0.0085])
def test_a_hole_as_wide_as_the_documentation_says_is_found_anywhere(x):
    """0.42 times the radius of the ring in diameter, from its middle to its edge."""
    for turn in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        place = np.array([[-x * np.cos(turn), -x * np.sin(turn), 0.01]])
        found = seal_cups(RayCaster(PLATE), CUP, place, DOWN[None])
        assert found.failures.tolist() == [SealFailure.HOLE.value]


@pytest.mark.parametrize(
    ("height", "failures"),
    [(0.02, [""]), (0.04, [SealFailure.WALL.value])],
)
def test_what_stands_in_the_cup_stays_below_its_wall(height, failures):
    """A pin of 2 mm radius fits in the cone down to 4 mm from the apex."""
    pin = trimesh.creation.cylinder(0.002, height).apply_translation([0, 0, height / 2 + 0.03])
    mesh = trimesh.util.concatenate([box(), pin])
    found = seal_cups(RayCaster(mesh), CUP, np.array([[0, 0, 0.03]]), DOWN[None])
    assert found.failures.tolist() == failures


def test_a_cup_does_not_pass_through_the_object():
    """On the inner wall of a hollow ball, the opposite wall is met first."""
    shell = trimesh.util.concatenate([sphere(0.045), sphere(0.042)])
    shell.faces[len(shell.faces) // 2 :] = shell.faces[len(shell.faces) // 2 :, ::-1]
    origins = np.array([[0, 0, -0.042], [0, 0, 0.045]])
    found = seal_cups(RayCaster(shell), CUP, origins, np.stack([DOWN, DOWN]))
    assert found.failures.tolist() == [SealFailure.BLOCKED.value, ""]


def test_a_cup_that_starts_in_the_object_does_not_seal():
    found = seal_cups(RayCaster(box(0.5)), CUP, np.array([[0.0, 0, 0.1]]), DOWN[None])
    assert found.failures.tolist() == [SealFailure.MISSED.value]


def test_many_cups_are_as_each_alone():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.04)
    points = np.random.default_rng(0).uniform(-0.027, 0.027, (60, 2))
    caster, origins, frames = from_above(mesh, points)
    together = seal_cups(caster, CUP, origins, frames)
    assert 0 < together.sealed.sum() < 60
    for i in range(60):
        alone = seal_cups(caster, CUP, origins[i : i + 1], frames[i : i + 1])
        for one, all_ in zip(alone, together, strict=True):
            assert_array_equal(one[0], all_[i])
    nothing = seal_cups(caster, CUP, origins[:0], frames[:0])
    assert len(nothing.failures) == len(nothing.strains) == 0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"radius": 0}, r"radius is 0; allowed: a number, above 0, at most 10 \(radius of the"),
        ({"sides": 4}, "sides is 4; allowed: a whole number, 5 to 360"),
        ({"vacuum": 3}, "'vacuum' is not known; did you mean vacuum_force"),
    ],
)
def test_wrong_values_of_a_cup_are_named(wrong, message):
    with pytest.raises(UserError, match=message):
        SuctionCup(**wrong)
