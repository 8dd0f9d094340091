"""A block that a hand can grasp, lying on a table, and settings to render it with."""

import numpy as np
import pytest
import trimesh

from egad.grippers import BoxBody
from egad.learning.images import PlacedObject, RenderParameters
from egad.learning.images.arrangement import TableGrasps
from egad_workflow.settings import Settings, select


@pytest.fixture(scope="session")
def block():
    """30 x 60 x 40 mm, around the origin."""
    return trimesh.creation.box((0.03, 0.06, 0.04))


@pytest.fixture(scope="session")
def lying(block):
    """The block as an object on a table."""
    place = trimesh.transformations.translation_matrix((0, 0, 0.02))
    return PlacedObject("id-1", 1.0, block, np.zeros(3), place, 0)


@pytest.fixture(scope="session")
def known_grasps():
    """Grasps on a table, all free and of quality 0.2, given centers, axes and widths."""

    def grasps(centers, axes, widths) -> TableGrasps:
        count = len(widths)
        return TableGrasps(
            objects=np.zeros(count, dtype=np.int64),
            centers=np.array(centers, dtype=float),
            axes=np.array(axes, dtype=float),
            widths=np.array(widths, dtype=float),
            free=np.ones(count, dtype=bool),
            qualities=np.full(count, 0.2),
            success=np.full(count, None),
        )

    return grasps


@pytest.fixture(scope="session")
def rendering():
    """Settings of the stage, with what a test changes."""

    def settings(gripper="egad_75mm", **changed) -> RenderParameters:
        whole = Settings.model_validate({"robust": {"samples": 5}, **changed})
        return select(whole, RenderParameters, gripper)

    return settings


@pytest.fixture(scope="session")
def hand(rendering):
    return BoxBody(rendering().gripper)
