"""The shipped network, and GG-CNN itself; they need the extra.

EGAD_GGCNN names a folder of the published weights of GG-CNN.
"""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.detectors import DETECTORS, DetectorConfig
from egad.detectors.registry import make_detector
from egad.detectors.subprocess import Child
from egad.grippers import GRIPPERS

pytest.importorskip("torch")
FOLDER = os.environ.get("EGAD_GGCNN")
HAND = GRIPPERS["egad_75mm"]
FIRST, SECOND = "ggcnn_epoch_23_cornell_statedict.pt", "epoch_50_cornell_statedict.pt"
SLOW = [
    pytest.mark.slow,
    pytest.mark.skipif(FOLDER is None, reason="EGAD_GGCNN names no folder"),
]
SHIPPED = DETECTORS["ggcnn2-evolved"]


def published(name):
    return DetectorConfig(detector="ggcnn", weights=str(Path(FOLDER or "") / name))


def off(angle):
    """How far an axis is from another, which have no direction."""
    return abs((angle + np.pi / 2) % np.pi - np.pi / 2)


@pytest.mark.parametrize(
    ("config", "most"),
    [
        pytest.param(published(FIRST), 0.2, marks=SLOW),
        pytest.param(published(SECOND), 0.5, marks=SLOW),
    ],
)
def test_a_bar_is_grasped_across(look, config, most):
    detect = make_detector(config)
    bar = trimesh.creation.box((0.03, 0.12, 0.04))
    for turn in (0.0, 0.4, 1.0, -0.7):
        first = detect(look(bar, 0.02, -0.03, turn), HAND, np.random.default_rng(0))[0]
        assert off(first.angle - turn) < most
        along = np.array([-np.sin(turn), np.cos(turn)])
        away = np.array(first.center[:2]) - (0.02, -0.03)
        assert abs(away @ along) < 0.065
        assert abs(away @ [along[1], -along[0]]) < 0.03
        assert first.quality > 0.6


@pytest.mark.parametrize("config", [SHIPPED, pytest.param(published(FIRST), marks=SLOW)])
def test_it_answers_from_a_process_of_its_own(look, config):
    view = look(trimesh.creation.box((0.03, 0.12, 0.04)))
    rng = np.random.default_rng(0)
    with Child(config, 60) as child:
        assert child(view, HAND, rng) == make_detector(config)(view, HAND, rng)
