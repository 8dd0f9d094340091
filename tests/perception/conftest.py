"""A block that a hand can grasp, and settings to render it with."""

import numpy as np
import pytest
import trimesh

from egad.grippers import BoxBody
from egad.perception.parameters import RenderParameters
from egad.perception.reachability import GraspCandidates
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select


@pytest.fixture(scope="session")
def block():
    """30 x 60 x 40 mm, around the origin."""
    return trimesh.creation.box((0.03, 0.06, 0.04))


@pytest.fixture(scope="session")
def grasped():
    """Grasps of the block: across its 30 mm, its 40 mm, and a slanted one that no hand holds."""
    axes = np.array([[1.0, 0, 0], [0, 0, 1.0], [1.0, 0, 0], [0.8, 0, 0.6]])
    centers = np.array([[0, 0.01, 0.005], [0.002, 0.0, 0], [0, -0.02, 0.0], [0, 0, 0]])
    widths = np.array([0.03, 0.04, 0.03, 0.0375])
    return GraspCandidates(np.array([4, 7, 9, 11]), centers, axes, widths, np.arange(4) / 10)


@pytest.fixture(scope="session")
def rendering():
    """Settings of the stage, with what a test changes."""

    def settings(gripper="egad_75mm", **changed) -> RenderParameters:
        return select(Settings.model_validate(changed), RenderParameters, gripper)

    return settings


@pytest.fixture(scope="session")
def hand(rendering):
    return BoxBody(rendering().gripper)
