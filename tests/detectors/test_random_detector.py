import numpy as np
import trimesh

from egad.detectors import View
from egad.detectors.random_detector import random_grasp
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]


def test_grasps_are_all_over_the_object_and_in_all_directions(look):
    view = look(trimesh.creation.box((0.04, 0.08, 0.05)), 0.03, -0.02)
    rng = np.random.default_rng(0)
    grasps = [random_grasp(view, HAND, rng)[0] for _ in range(400)]
    places = np.array([grasp.center[:2] for grasp in grasps]) - (0.03, -0.02)
    assert (np.abs(places) < (0.023, 0.045)).all()
    np.testing.assert_allclose(places.std(axis=0), np.array([0.04, 0.08]) / 12**0.5, rtol=0.15)
    angles = [grasp.angle for grasp in grasps]
    assert np.histogram(angles, 4, (-np.pi / 2, np.pi / 2))[0].min() > 70
    assert all(grasp.infeasibility(HAND) is None for grasp in grasps)


def test_chance_is_the_seeds(look):
    view = look(trimesh.creation.box((0.04, 0.08, 0.05)))
    one, same, other = (random_grasp(view, HAND, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one == same != other


def test_an_empty_table_gives_nothing(look):
    view = look(trimesh.creation.box((0.1, 0.1, 0.001)))
    assert random_grasp(view, HAND, np.random.default_rng(0)) == []
    blind = View(np.full_like(view.depth, np.nan), view.intrinsics, view.pose)
    assert random_grasp(blind, HAND, np.random.default_rng(0)) == []
