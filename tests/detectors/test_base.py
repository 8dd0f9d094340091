from dataclasses import replace

import numpy as np
import pytest

from egad.detectors import Grasp, best_grasp
from egad.detectors.base import MAX_GRASPS, rank_grasps
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]
FINE = Grasp((0.0, 0.0, 0.02), 0.0, 0.05, 0.01, 0.5)
NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "flaw"),
    [
        ({}, None),
        ({"width": 0.075}, None),
        ({"width": 0.0}, None),
        ({"depth": 0.02}, None),
        ({"width": 0.0751}, "too_wide"),
        ({"width": -0.001}, "too_wide"),
        ({"depth": 0.021}, "below_table"),
        ({"center": (0.0, 0.0, -0.01)}, "below_table"),
        ({"center": (0.0, NAN, 0.02)}, "not_finite"),
        ({"angle": NAN}, "not_finite"),
        ({"width": float("inf")}, "not_finite"),
        ({"quality": NAN}, "not_finite"),
    ],
)
def test_flaws(change, flaw):
    assert replace(FINE, **change).infeasibility(HAND) == flaw


def test_the_best_is_of_the_highest_quality_that_the_hand_can_do():
    poorer = replace(FINE, quality=0.3)
    too_wide = replace(FINE, width=0.2, quality=0.9)
    nowhere = replace(FINE, center=(0.0, NAN, 0.02), quality=0.8)
    unsure = replace(FINE, quality=float("inf"))
    assert best_grasp([poorer, too_wide, FINE, nowhere, unsure], HAND) == FINE
    assert best_grasp([nowhere, too_wide], HAND) == "too_wide"
    assert best_grasp([unsure], HAND) == "not_finite"
    assert best_grasp([], HAND) == "no_grasp"


def test_of_equals_the_first_is_taken():
    other = replace(FINE, angle=1.0)
    assert best_grasp([other, FINE], HAND) == other
    assert best_grasp([FINE, other], HAND) == FINE


@pytest.mark.parametrize("count", [0, 1, 7, 80])
def test_candidates_are_ranked_as_one_would_one_by_one(count):
    rng = np.random.default_rng(count)
    center, axis = rng.normal(size=(count, 3)), rng.normal(size=(count, 2))
    (width, depth), quality = rng.random((2, count)), rng.integers(5, size=count) / 4
    slow = [
        Grasp(tuple(center[i]), np.arctan2(axis[i, 1], axis[i, 0]), width[i], depth[i], quality[i])
        for i in range(count)
    ]
    slow.sort(key=lambda grasp: -grasp.quality)
    assert rank_grasps(center, axis, width, depth, quality) == slow[:MAX_GRASPS]
