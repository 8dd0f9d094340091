"""labels in scenes: grasps of any object from any side that the rest leaves free."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from worlds import HAND

from egad.bench import RestingObject
from egad.bench.scene_labels import SceneLabels
from egad.detectors import Grasp, Observation
from egad.geometry import Bundle
from egad.grasps import label_parameters
from egad.grasps.sampling import dataset_grasps
from egad.grippers import BoxBody
from egad.sim.execution import STANDOFF
from egad.sim.model import Model, build
from egad.sim.world import Pose
from egad.tables.outcomes import Outcome

MESH = trimesh.creation.box((0.03, 0.05, 0.08))
MODEL = build(MESH, 600.0, Bundle())
WANTED = label_parameters(HAND, 100, 0)
GRASPS = dataset_grasps(MESH, "box", WANTED)


def placed(number: int, x: float, y: float, z: float, turn: Rotation) -> RestingObject:
    quaternion = (turn * Rotation.from_matrix(MODEL.to_principal[:3, :3].T)).as_quat()
    return RestingObject(number, Pose(np.array([x, y, z]), quaternion))


def propose(
    present: list[RestingObject], models: list[Model], tables: list[pd.DataFrame]
) -> Grasp | Outcome:
    labels = SceneLabels(tables, models, HAND)
    nothing = Observation(None, (), 0.3)  # type: ignore[arg-type]
    return labels(nothing, present, np.random.default_rng(0))


def touched(pose: np.ndarray, present: list[RestingObject], models: list[Model]) -> bool:
    """Whether points of the scene lie in the hand, anywhere on its way."""
    clouds = [np.random.default_rng(0).uniform([-0.3, -0.3, 0], [0.3, 0.3, 0], (40000, 3))]
    for number, where in present:
        points = trimesh.sample.sample_surface(models[number].mesh, 40000, seed=0)[0]
        clouds.append(points @ where.matrix[:3, :3].T + where.position)
    local = (np.concatenate(clouds) - pose[:3, 3]) @ pose[:3, :3]
    return any(
        bool(((local > part.box[0] + 5e-4) & (local < part.box[1] - 5e-4)).all(axis=1).any())
        for part in BoxBody(HAND).parts(STANDOFF)
    )


@pytest.mark.parametrize("factor", [1.0, 0.8])
@pytest.mark.parametrize("turn", range(6))
def test_the_hand_is_free_and_closes_on_the_object(factor: float, turn: int) -> None:
    """Two boxes beside each other, turned at random, the second one lying somewhere."""
    models = [MODEL.scaled(factor)] * 2
    random = Rotation.random(2, rng=np.random.default_rng(turn))
    present = [placed(0, 0, 0, 0.05, random[0]), placed(1, 0.07, 0.02, 0.05, random[1])]
    best = propose(present, models, [GRASPS] * 2)
    assert isinstance(best, Grasp)
    assert not touched(best.pose, present, models)
    assert best.width == HAND.opening
    nearest = min(
        np.abs(
            Rotation.from_quat(where.quaternion).inv().apply(best.pose[:3, 3] - where.position)
        ).max()
        for _, where in present
    )
    assert nearest < 0.04


def test_without_a_free_grasp_there_is_none() -> None:
    """A plate too wide for the hand: in the air it can be had, flat on the table it cannot."""
    assert propose([], [MODEL], [GRASPS]) == Outcome.NO_GRASP
    mesh = trimesh.creation.box((0.12, 0.12, 0.02))
    plate, grasps = build(mesh, 600.0, Bundle()), dataset_grasps(mesh, "plate", WANTED)
    flat = Rotation.from_matrix(plate.to_principal[:3, :3].T).as_quat()
    in_the_air, lying = ([RestingObject(0, Pose(np.array([0, 0, z]), flat))] for z in (0.3, 0.01))
    assert isinstance(propose(in_the_air, [plate], [grasps]), Grasp)
    assert propose(lying, [plate], [grasps]) == Outcome.NO_GRASP
    blocked = GRASPS.assign(collision_free=False)
    upright = [placed(0, 0, 0, 0.04, Rotation.identity())]
    assert propose(upright, [MODEL], [blocked]) == Outcome.NO_GRASP


def test_the_grasp_of_the_highest_quality_is_taken() -> None:
    upright = [placed(0, 0, 0, 0.2, Rotation.identity())]  # in the air: all are free
    best = propose(upright, [MODEL], [GRASPS])
    assert isinstance(best, Grasp)
    free = GRASPS[GRASPS["collision_free"]]
    assert best.quality == free["robust_quality"].max()
