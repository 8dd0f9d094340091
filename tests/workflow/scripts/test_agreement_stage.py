"""Labelled grasps of a bundle carried out, whatever is in it, in any number of shards."""

import agreement
import grasp_label
import pandas as pd
import pytest
import trimesh
from dying_worker import Dying

from egad.exchange import evaluation_objects, write_bundle
from egad.grasps.parameters import LabelParameters
from egad.io import write_obj
from egad.sim import SimulationBundle
from egad.sim.parameters import LabelTrialParameters
from egad.tables import parquet
from egad.tables.evaluation import AGREEMENT, EVAL49
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings, select

WHOLE = Settings.model_validate({"agreement": {"grasps": 11}, "grasp_label": {"grasps": 20}})
SETTINGS = select(WHOLE, LabelTrialParameters, "egad_75mm")
BOX = trimesh.creation.box((0.04, 0.04, 0.04))
MESHES = {
    "A0": trimesh.creation.box((0.04, 0.03, 0.05)),
    "A1": trimesh.creation.cylinder(0.02, 0.07),
    "B0": BOX,  # not in the bundle
}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """A folder as the pipeline makes it."""
    folder = tmp_path_factory.mktemp("results") / "egad"
    meshes, evaluation = folder / "rescaled" / "egad_75mm", folder / "eval49.parquet"
    names = {name: {"label": name, "id": f"id-{name}", "object_label": name} for name in MESHES}
    rows = [dict.fromkeys(EVAL49.names, 0) | each for each in names.values()]
    for name, mesh in MESHES.items():
        write_obj(mesh, meshes / f"{name}.obj")
    parquet.write(pd.DataFrame(rows), EVAL49, evaluation)
    objects = [dict.fromkeys(OBJECTS.names, 0) | names[name] for name in MESHES]
    table = pd.DataFrame(objects)[OBJECTS.names]
    parquet.write(table, OBJECTS, folder / "objects.parquet")
    out = [folder / f"{name}.parquet" for name in ("grasps", "tally", "rejected")]
    settings = select(WHOLE, LabelParameters, "egad_75mm")
    grasp_label.run(settings, folder / "objects.parquet", meshes, (0, 1), *out)
    items = [item for item in evaluation_objects(evaluation, meshes) if item.label != "B0"]
    write_bundle(select(WHOLE, SimulationBundle), items, "m", folder / "bundle")
    return folder


def executed(dataset, out, shard=(0, 1)):
    paths = [dataset / name for name in ("eval49.parquet", "bundle", "grasps.parquet")]
    agreement.run(SETTINGS, *paths, shard, out)
    return parquet.read(out, AGREEMENT)


@pytest.fixture(scope="module")
def table(dataset):
    return executed(dataset, dataset / "agreement.parquet")


def test_every_object_has_its_share_and_one_without_a_model_fails(table):
    assert table.groupby("label").size().to_dict() == {"A0": 3, "A1": 4, "B0": 4}
    outcomes = table.groupby("label")["outcome"].unique()
    assert set(outcomes["B0"]) == {"failed"}
    assert table.loc[table["label"] != "B0", "success"].any()
    assert (table["success"] == (table["outcome"] == "success")).all()


def test_shards_together_have_the_same_rows(dataset, table, tmp_path):
    frames = [executed(dataset, tmp_path / f"{n}.parquet", (n, 2)) for n in range(2)]
    filled = [frame for frame in frames if len(frame)]
    together = pd.concat(filled).sort_values(["label", "grasp"], ignore_index=True)
    pd.testing.assert_frame_equal(together, table, check_exact=True)


def test_an_object_that_ends_the_process_twice_is_marked(dataset, tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(agreement, "open_agreement", Dying)
    outcomes = executed(dataset, tmp_path / "out.parquet").groupby("label")["outcome"].unique()
    assert {label: set(found) for label, found in outcomes.items()} == {
        "A0": {"crashed"},
        "A1": {"crashed"},
        "B0": {"failed"},
    }
    assert "A0 (id-A0): everything crashed" in caplog.text
