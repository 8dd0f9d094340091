"""How far a hand opens beside what it holds."""

import numpy as np

from egad.grasps.collision import SIDE_CLEARANCE, roomy
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]


def test_there_is_room_on_both_sides_as_far_as_the_hand_opens():
    distance = np.array([0.0, 0.03, HAND.opening - 2 * SIDE_CLEARANCE, 0.07, HAND.opening])
    width = roomy(distance, HAND)
    assert (width <= HAND.opening).all()
    np.testing.assert_allclose((width - distance)[:3] / 2, SIDE_CLEARANCE)
    assert width[3:].tolist() == [HAND.opening] * 2
