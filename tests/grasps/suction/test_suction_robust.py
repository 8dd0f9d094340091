import numpy as np
import pytest
from cup_shapes import box, from_above
from numpy.testing import assert_array_equal
from scipy.stats import norm

from egad.grasps import RobustSuction
from egad.grasps.suction import robust_suction_quality, seal_cups
from egad.grippers import SuctionCup

CUP = SuctionCup()
CALM = RobustSuction(**dict.fromkeys([n for n in RobustSuction.model_fields if "sigma" in n], 0))


def rate(mesh, points, *, cup=CUP, com=(0, 0, 0), weight=0.85, seed=0, indices=None, **robust):
    caster, origins, frames = from_above(mesh, points)
    return robust_suction_quality(
        caster,
        cup,
        origins,
        frames,
        np.array(com, dtype=float),
        np.tile([0.0, 0, -weight], (len(origins), 1)),
        robust=CALM.model_copy(update=robust),
        seed=seed,
        indices=np.arange(len(origins)) if indices is None else np.array(indices),
    )


def test_without_perturbation_it_is_nominal():
    found = rate(box(), [[0, 0], [0.0149, 0], [0.0151, 0]])
    assert found.tolist() == [1, 1, 0]
    assert rate(box(), [[0, 0]], weight=251).tolist() == [0]


@pytest.mark.parametrize("moved", ["object_translation_sigma", "cup_translation_sigma"])
def test_it_falls_towards_the_edge_as_the_position_is_uncertain(moved):
    places = np.array([0, 0.008, 0.012, 0.015, 0.018, 0.025])
    found = rate(box(), np.column_stack([places, 0 * places]), samples=4000, **{moved: 0.005})
    # the ring has a vertex towards the edge; across it reaches r cos(pi / 30) on both sides
    across = 2 * norm.cdf((0.03 - CUP.radius * np.cos(np.pi / 30)) / 0.005) - 1
    expected = norm.cdf((0.015 - places) / 0.005) - norm.cdf((-0.0155 - places) / 0.005)
    assert np.all(np.diff(found) < 0)
    assert found == pytest.approx(across * expected, abs=0.025)


@pytest.mark.parametrize("turned", ["object_rotation_sigma", "cup_rotation_sigma"])
def test_it_falls_with_the_tilt_as_the_orientation_is_uncertain(turned):
    """The cone bears a tilt of tan(angle) = 0.2475, and two of three components tilt it."""
    found = rate(box(1.0), [[0, 0]], weight=1e-6, samples=4000, com=(0, 0, 0.5), **{turned: 0.15})
    assert found == pytest.approx(1 - np.exp(-(np.arctan(0.2475) ** 2) / (2 * 0.15**2)), abs=0.03)


def test_the_object_turns_about_its_center_of_mass():
    """Far from it a turn moves the face away, or tilts no more than it does near it."""
    near = rate(box(), [[0, 0]], samples=1000, com=(0, 0, 0.03), object_rotation_sigma=0.1)[0]
    far = rate(box(), [[0, 0]], samples=1000, com=(0, 0, 0.23), object_rotation_sigma=0.1)[0]
    assert far < near - 0.1


def test_uncertain_friction_and_weight_decide_at_their_limits():
    cup = SuctionCup(vacuum_force=5)
    found = rate(box(), [[0, 0]], cup=cup, weight=5, samples=4000, weight_sigma=0.1)[0]
    assert found == pytest.approx(0.5, abs=0.025)
    caster, origins, frames = from_above(box(), [[0, 0]])
    side = np.array([[cup.friction * 5 / np.sqrt(3), 0, 0]])  # all that friction carries
    found = robust_suction_quality(
        caster,
        cup,
        origins,
        frames,
        origins[0],
        side,
        robust=CALM.model_copy(update={"samples": 4000, "friction_sigma": 0.1}),
        seed=0,
        indices=np.array([0]),
    )
    assert found == pytest.approx(0.5, abs=0.025)


def test_an_uncertain_center_of_mass_bends_the_cup():
    """The tolerance carries 1 N at about 31.8 mm beside the axis."""
    found = rate(box(), [[0, 0]], weight=1, samples=4000, com_sigma=0.02)[0]
    assert found == pytest.approx(1 - np.exp(-(0.0318**2) / (2 * 0.02**2)), abs=0.025)


def test_a_grasp_has_the_same_quality_in_any_company():
    points = np.random.default_rng(1).uniform(-0.02, 0.02, (12, 2))
    sigmas = RobustSuction().model_dump()
    together = rate(box(), points, **sigmas)
    assert len(set(together)) > 3
    order = np.random.default_rng(2).permutation(12)
    assert_array_equal(rate(box(), points[order], indices=order, **sigmas), together[order])
    alone = [rate(box(), points[i : i + 1], indices=[i], **sigmas)[0] for i in range(12)]
    assert_array_equal(alone, together)
    assert not np.array_equal(rate(box(), points, seed=1, **sigmas), together)
    assert len(rate(box(), points[:0], **sigmas)) == 0


def test_the_position_along_the_approach_does_not_matter():
    """The cup moves on until it meets the object: 10 mm up or down are no difference."""
    caster, origins, frames = from_above(box(), [[0, 0]] * 3)
    origins[:, 2] += [0, 0.01, -0.01]
    assert seal_cups(caster, CUP, origins, frames).sealed.all()
