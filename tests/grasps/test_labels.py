import re

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.errors import RejectedError
from egad.geometry.rays import RayCaster
from egad.grasps import GraspLabel, SamplingStatistics, sample_contacts
from egad.grasps.labels import sample_for_labels, statistics_row
from egad.grasps.parameters import LabelParameters
from egad.grasps.sampling import Labeller, dataset_grasps
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(), LabelParameters, gripper="yumi").model_copy(
    update={"grasp_label": GraspLabel(grasps=40)}
)
MESH = trimesh.creation.cylinder(0.02, 0.08, sections=48)


def labels(mesh=MESH, seed=0):
    return Labeller(SETTINGS)(mesh, mesh.center_mass, np.random.default_rng(seed)).table


def vectors(frame, name):
    return frame[[f"{name}_{part}" for part in "xyz"]].to_numpy()


def test_columns_are_those_of_the_table(tmp_path):
    frame = labels()
    expected = [name for name in GRASPS.names if name not in ("id", "label")]
    assert list(frame.columns) == expected
    assert frame["grasp"].tolist() == list(range(40))
    path = tmp_path / "grasps.parquet"
    parquet.write(frame.assign(id="a", label="A00_0"), GRASPS, path)
    assert len(parquet.read(path, GRASPS)) == 40


def test_same_seed_gives_the_same_rows():
    assert labels().equals(labels())
    assert not labels().equals(labels(seed=1))


def test_an_object_without_grasps_is_rejected_with_the_reason():
    box = trimesh.creation.box([0.06, 0.06, 0.06])
    found = Labeller(SETTINGS)(box, box.center_mass, np.random.default_rng(0))
    assert re.match(r"no grasp \(of 2000 candidates: \d+ too wide, ", found.reason)
    assert found.table.empty
    with pytest.raises(RejectedError, match=r"no grasp \(of "):
        dataset_grasps(box, "box", SETTINGS)


def test_grasps_are_kept_that_no_horizontal_approach_reaches():
    ring = trimesh.creation.torus(0.03, 0.008)
    rng = np.random.default_rng
    _, sampled = sample_contacts(
        RayCaster(ring), SETTINGS.gripper.opening, 40, SETTINGS.sampling, rng(0)
    )
    _, statistics = sample_for_labels(RayCaster(ring), SETTINGS, rng(0))
    assert sampled.blocked > 0
    assert statistics.blocked == 0


def test_what_became_of_the_grasps_is_counted_once():
    """A hand that does not fit at a grasp cannot come there either."""
    grasps = pd.DataFrame(
        {
            "quality": [0.001, 0.0, 0.002, 0.003],
            "fits": [True, True, False, False],
            "collision_free": [True, False, False, False],
        }
    )
    row = statistics_row(5, SamplingStatistics(candidates=9, too_wide=2, blocked=1), grasps)
    assert (row["n_grasps"], row["n_in_collision"], row["n_unreachable"]) == (4, 2, 1)
    assert (row["n_slipping"], row["n_surplus"]) == (1, 2)
