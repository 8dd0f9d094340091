"""How far to open and how deep to reach beside what is seen."""

import numpy as np
import pytest
import trimesh

from egad.detectors.heightmap import PROBE, heightmap_of, min_fingertip_height
from egad.grasps.collision import TABLE_CLEARANCE
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]


def test_fingers_reach_the_table_beside_a_box_and_its_top_on_it(look):
    box = trimesh.creation.box((0.03, 0.2, 0.04))
    heightmap = heightmap_of(look(box))
    assert heightmap is not None
    middle, width = np.zeros((2, 2)), np.full(2, 0.06)
    tips = min_fingertip_height(middle, np.eye(2), width, heightmap, HAND)
    np.testing.assert_allclose(tips, [TABLE_CLEARANCE, 0.04 + TABLE_CLEARANCE], atol=1e-4)
    assert heightmap_of(look(trimesh.creation.box((0.1, 0.1, 0.001)))) is None


@pytest.mark.parametrize(
    "gripper", ["egad_75mm", "yumi"]
)  # a palm that is high, and one that is low
def test_tips_are_those_of_probes_one_by_one(look, gripper):
    hand = GRIPPERS[gripper]
    low = trimesh.creation.box(bounds=[(-0.05, -0.05, 0), (0.05, 0.05, 0.02)])
    tower = trimesh.creation.box(bounds=[(0.02, 0, 0), (0.05, 0.03, 0.09)])
    heightmap = heightmap_of(look(trimesh.util.concatenate([low, tower])))
    assert heightmap is not None
    rng = np.random.default_rng(0)
    middle, turn = rng.uniform(-0.08, 0.08, (60, 2)), rng.uniform(0, np.pi, 60)
    axis, width = np.column_stack([np.cos(turn), np.sin(turn)]), rng.uniform(0.01, 0.05, 60)
    found = min_fingertip_height(middle, axis, width, heightmap, hand)

    def height(point):
        column, row = np.floor((point - heightmap.origin) / heightmap.cell).astype(int)
        inside = 0 <= column < heightmap.heights.shape[0] and 0 <= row < heightmap.heights.shape[1]
        return heightmap.heights[column, row] if inside else 0.0

    def highest(number, center, length, across):
        sides = [
            np.linspace(-side / 2, side / 2, int(np.ceil(side / PROBE)) + 1)
            for side in (length, across)
        ]
        x, y = axis[number], np.array([-axis[number][1], axis[number][0]])
        places = [middle[number] + (center + a) * x + b * y for a in sides[0] for b in sides[1]]
        return max(map(height, places))

    thick, wide = hand.finger_thickness, hand.finger_width
    for number, tip in enumerate(found):
        off = (width[number] + thick) / 2
        fingers = max(highest(number, side * off, thick, wide) for side in (1, -1))
        palm = highest(number, 0.0, *hand.palm[:2]) - hand.finger_length
        assert tip == pytest.approx(max(fingers, palm, 0.0) + TABLE_CLEARANCE, abs=1e-6)
