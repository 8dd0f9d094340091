"""How far to open and how deep to reach beside what is seen."""

import numpy as np
import trimesh

from egad.grasps.room import TABLE_CLEARANCE
from egad.settings import GRIPPERS
from egad.trials.relief import lowest_tip, relief_of

HAND = GRIPPERS["egad_75mm"]


def test_fingers_reach_the_table_beside_a_box_and_its_top_on_it(look):
    box = trimesh.creation.box((0.03, 0.2, 0.04))
    relief = relief_of(look(box))
    assert relief is not None
    middle, width = np.zeros((2, 2)), np.full(2, 0.06)
    tips = lowest_tip(middle, np.eye(2), width, relief, HAND)
    np.testing.assert_allclose(tips, [TABLE_CLEARANCE, 0.04 + TABLE_CLEARANCE], atol=1e-4)
    assert relief_of(look(trimesh.creation.box((0.1, 0.1, 0.001)))) is None
