"""GG-CNN itself. EGAD_GGCNN names a folder of its published weights; it needs the extra."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.detectors.ggcnn import GGCNN
from egad.detectors.subprocess import Child
from egad.pipeline.config import GRIPPERS, DetectorConfig

pytest.importorskip("torch")
FOLDER = os.environ.get("EGAD_GGCNN")
HAND = GRIPPERS["egad_75mm"]
FIRST, SECOND = "ggcnn_epoch_23_cornell_statedict.pt", "epoch_50_cornell_statedict.pt"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(FOLDER is None, reason="EGAD_GGCNN names no folder"),
]


def published(name):
    return str(Path(FOLDER or "") / name)


def off(angle):
    """How far an axis is from another, which have no direction."""
    return abs((angle + np.pi / 2) % np.pi - np.pi / 2)


@pytest.mark.parametrize(("name", "most"), [(FIRST, 0.2), (SECOND, 0.5)])
def test_a_bar_is_grasped_across(look, name, most):
    detect = GGCNN(published(name))
    bar = trimesh.creation.box((0.03, 0.12, 0.04))
    for turn in (0.0, 0.4, 1.0, -0.7):
        first = detect(look(bar, 0.02, -0.03, turn), HAND, np.random.default_rng(0))[0]
        assert off(first.angle - turn) < most
        along = np.array([-np.sin(turn), np.cos(turn)])
        away = np.array(first.center[:2]) - (0.02, -0.03)
        assert abs(away @ along) < 0.065
        assert abs(away @ [along[1], -along[0]]) < 0.03
        assert first.quality > 0.6


def test_it_answers_from_a_process_of_its_own(look):
    view = look(trimesh.creation.box((0.03, 0.12, 0.04)))
    rng = np.random.default_rng(0)
    with Child(DetectorConfig(detector="ggcnn", weights=published(FIRST)), 60) as child:
        assert child(view, HAND, rng) == GGCNN(published(FIRST))(view, HAND, rng)
