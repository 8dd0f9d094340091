"""The picture of hands around an object: they are drawn where they are, at their size."""

import re

import numpy as np
import pytest
import trimesh
from svg_text import texts

from egad.grippers import gripper
from egad.report.grasps import AROUND, STEM, hands_chart
from egad.report.pictures import CAMERA, FILL

BALL = trimesh.creation.icosphere(3, 0.03)
HAND = gripper("panda")


def drawn_lines(svg):
    """The polylines with seven points, (n, 7, 2), points of the page, y down."""
    paths = re.findall(r'<path d="([^"]*)"', svg)
    lines = [re.findall(r"[ML] (\S+) (\S+)", path) for path in paths]
    return np.array([line for line in lines if len(line) == 7], dtype=float)


def test_hands_have_their_size_and_place():
    """Two hands that face the viewer, of which one is 2 cm to the right of the other."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, :3] = np.stack([CAMERA[0], CAMERA[2], -CAMERA[1]], axis=1)
    poses[1, :3, 3] = 0.02 * CAMERA[0]
    svg = hands_chart(BALL, {"as read": poses, "corrected": poses[:1]}, HAND)
    assert texts(svg) == ["as read", "corrected"]
    lines = drawn_lines(svg)
    assert len(lines) == 3
    width = np.linalg.norm(lines[:, 6] - lines[:, 0], axis=1)
    scale = width / HAND.opening
    assert scale == pytest.approx(np.full(3, scale[0]), rel=1e-4)
    assert (lines[1] - lines[0]) / scale[0] == pytest.approx(np.tile([0.02, 0], (7, 1)), abs=1e-5)
    palm, tip = HAND.kind.span
    outline = (lines[0] - lines[0, 0]) / scale[0]
    assert outline[1] == pytest.approx(np.array([0, -(tip - palm)]), abs=1e-5)  # up: away from it
    assert outline[3] == pytest.approx(np.array([0.04, -(tip - palm + STEM)]), abs=1e-5)
    side = 2 * (0.03 / FILL + AROUND[1]) * scale[0]
    assert 200 < side < 4.3 * 72
