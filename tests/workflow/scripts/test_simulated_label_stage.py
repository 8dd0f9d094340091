"""Simulated labels of a shard: every grasp keeps its row, whatever becomes of its object."""

import numpy as np
import pandas as pd
import pytest
import simulated_label
import trimesh
from dying_worker import Dying
from partial_tables import write_rows

from egad.errors import UserError
from egad.geometry import Bundle
from egad.io import write_obj
from egad.sim import SimulatedLabels, make_simulation_object, part_rows
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import GRASPS, SIMULATED_GRASPS
from egad_workflow.settings import Settings, select

SETTINGS = select(
    Settings.model_validate({"simulated_label": {"grasps": 2}}),
    SimulatedLabels,
    "egad_75mm",
)
BOX = trimesh.creation.box((0.04, 0.04, 0.04))
OPEN = trimesh.Trimesh(BOX.vertices, BOX.faces[1:], process=False)


@pytest.fixture
def shard(tmp_path):
    """Grasps of a box, and of a surface that is no solid and has no convex parts."""
    rows = [
        {"label": label, "id": f"id-{label}", "fits": True, "collision_free": number > 0}
        | {"grasp": number, "axis_x": 1.0, "approach_z": -1.0, "width": 0.04}
        for label in ("A00_0", "B00_0")
        for number in range(3)
    ]
    write_rows(GRASPS, rows, tmp_path / "grasps.parquet")
    parts = part_rows(make_simulation_object(BOX, 400, Bundle()))
    table = parts.assign(label="A00_0", id="id-A00_0")
    parquet.write(table, CONVEX_PARTS, tmp_path / "convex_parts.parquet")
    write_obj(BOX, tmp_path / "meshes/A00_0.obj")
    write_obj(OPEN, tmp_path / "meshes/B00_0.obj")
    return tmp_path


def labels(shard):
    files = (shard / name for name in ("grasps.parquet", "convex_parts.parquet", "meshes"))
    simulated_label.run(SETTINGS, *files, shard / "out.parquet")
    return parquet.read(shard / "out.parquet", SIMULATED_GRASPS)


def test_every_grasp_keeps_its_row(shard):
    found = labels(shard)
    before = parquet.read(shard / "grasps.parquet", GRASPS)
    pd.testing.assert_frame_equal(found[GRASPS.names], before)
    outcomes = found["simulated_outcome"].fillna("").to_numpy().reshape(2, 3).tolist()
    assert outcomes == [["", "success", "success"], ["", "failed", "failed"]]
    assert found["simulated_success"].dropna().tolist() == [True, True]


def test_a_missing_mesh_is_an_error(shard):
    (shard / "meshes/A00_0.obj").unlink()
    with pytest.raises(UserError, match=r"A00_0\.obj"):
        labels(shard)


def test_a_crash_of_the_engine_is_an_outcome(shard, monkeypatch):
    monkeypatch.setattr(simulated_label, "open_labels", Dying)
    assert set(labels(shard)["simulated_outcome"].dropna()) == {"crashed"}


def test_tables_without_simulated_labels_are_read_as_unknown(shard):
    found = parquet.read(shard / "grasps.parquet", SIMULATED_GRASPS)
    assert found["simulated_outcome"].isna().all()
    assert np.isnan(found["simulated_shaking_turn"]).all()
