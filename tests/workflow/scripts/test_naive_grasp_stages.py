"""Naive grasps of a shard, and success rates of objects, whatever becomes of their grasps."""

import naive_grasp
import numpy as np
import pandas as pd
import pytest
import simulated_success_rate
import trimesh
from dying_worker import Dying
from partial_tables import write_rows

from egad.bench import NaiveGrasps, try_naive_grasps
from egad.errors import UserError
from egad.geometry import Bundle
from egad.io import write_obj
from egad.sim import build, make_simulation_object, part_rows
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import GRASPS, NAIVE_GRASPS, SIMULATED_GRASPS, SIMULATED_OBJECTS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings.model_validate({"naive_grasp": {"grasps": 4}}), NaiveGrasps, "egad_75mm")
BOX = trimesh.creation.box((0.03, 0.04, 0.05))
NAMES = {"A00_0": "id-a", "B00_0": "id-b"}


@pytest.fixture
def shard(tmp_path):
    """Two boxes."""
    parts = part_rows(make_simulation_object(BOX, 400, Bundle()))
    tables = [parts.assign(label=label, id=name) for label, name in NAMES.items()]
    parquet.write(pd.concat(tables), CONVEX_PARTS, tmp_path / "convex_parts.parquet")
    for label in NAMES:
        write_obj(BOX, tmp_path / f"meshes/{label}.obj")
    return tmp_path


def tried(shard):
    files = (shard / name for name in ("convex_parts.parquet", "meshes"))
    naive_grasp.run(SETTINGS, *files, shard / "naive.parquet")
    return parquet.read(shard / "naive.parquet", NAIVE_GRASPS)


def test_another_process_tries_the_same_grasps_whatever_it_tried_before(shard):
    found = tried(shard)
    assert found["label"].tolist() == [label for label in NAMES for _ in range(8)]
    model = build(BOX, SETTINGS.material.density, Bundle())
    own = try_naive_grasps(model, "id-b", SETTINGS)
    again = found[found["id"] == "id-b"].reset_index(drop=True)
    pd.testing.assert_frame_equal(again[list(own)], own, check_dtype=False)


def test_a_crash_of_the_engine_is_an_outcome(shard, monkeypatch):
    monkeypatch.setattr(naive_grasp, "open_naive_grasps", Dying)
    found = tried(shard)
    assert len(found) == 16
    assert set(found["outcome"]) == {"crashed"}


def naive_table(path, names):
    rows = [
        {"label": label, "id": name, "place": place, "number": n, "outcome": outcome}
        for label, name in names.items()
        for place, outcomes in (("free", ("success", "missed")), ("table", ("crashed", "crashed")))
        for n, outcome in enumerate(outcomes)
    ]
    parquet.write(pd.DataFrame(rows).assign(engine="mujoco"), NAIVE_GRASPS, path)


def test_every_object_with_simulated_grasps_of_any_kind_has_a_row(tmp_path):
    one = {"label": "A00_0", "id": "id-a", "simulated_success": True}
    tried = one | {"simulated_outcome": "success", "simulated_engine": "mujoco"}
    write_rows(SIMULATED_GRASPS, [tried], tmp_path / "grasps.parquet")
    naive_table(tmp_path / "naive.parquet", {"B00_0": "id-b", "C00_0": "id-c"})
    files = (tmp_path / f"{name}.parquet" for name in ("grasps", "naive", "out"))
    simulated_success_rate.run(*files)
    found = parquet.read(tmp_path / "out.parquet", SIMULATED_OBJECTS)
    assert found["label"].tolist() == ["A00_0", "B00_0", "C00_0"]
    assert found["n_simulated"].tolist() == [1, 0, 0]
    assert found["n_free"].tolist() == [0, 2, 2]
    assert found["n_table"].tolist() == [0, 0, 0]
    np.testing.assert_array_equal(found["antipodal_success_rate"], [1, np.nan, np.nan])
    np.testing.assert_array_equal(found["simulated_success_rate"], [np.nan, 0.5, 0.5])
    np.testing.assert_allclose(found["simulated_success_rate_std"], [np.nan, *[8**-0.5] * 2])
    assert found["table_success_rate"].isna().all()


def test_grasps_without_simulated_labels_are_refused(tmp_path):
    parquet.write(parquet.empty(GRASPS), GRASPS, tmp_path / "grasps.parquet")
    naive_table(tmp_path / "naive.parquet", NAMES)
    files = (tmp_path / f"{name}.parquet" for name in ("grasps", "naive", "out"))
    with pytest.raises(UserError, match="simulated_labels: true"):
        simulated_success_rate.run(*files)
