"""Graspability of the objects of a dataset for a gripper, against `egad.measure`."""

import graspability
import pandas as pd
import pytest
import trimesh
from described_hands import box_urdf
from partial_tables import write_rows

import egad
from egad.geometry import in_single_precision
from egad.grippers import GRIPPERS, Gripper
from egad.io import write_obj
from egad.measures import GraspabilityOfGripper, Postprocess
from egad.tables import parquet
from egad.tables.objects import GRASPABILITIES, OBJECTS
from egad_workflow.settings import Settings, select


@pytest.fixture
def dataset(tmp_path, lumpy):
    """Two objects, one of them flat."""
    write_rows(OBJECTS, [{"label": "A0"}, {"label": "B0"}], tmp_path / "objects.parquet")
    write_obj(in_single_precision(lumpy), tmp_path / "A0.obj")
    trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).export(tmp_path / "B0.obj")
    return tmp_path


def test_a_gripper_by_file_measures_as_its_opening_does(dataset):
    hand = Gripper.from_file(box_urdf(dataset / "hand.urdf"))
    grippers = GRIPPERS | {"mine": hand}
    whole = Settings(grippers=grippers, postprocess=Postprocess(max_candidates=256))
    tables = {}
    for name in ("mine", "yumi"):
        settings = select(whole, GraspabilityOfGripper, name)
        graspability.run(settings, dataset / "objects.parquet", dataset, dataset / "out.parquet")
        tables[name] = parquet.read(dataset / "out.parquet", GRASPABILITIES).set_index("label")
        mesh = egad.read_mesh(dataset / "A0.obj", units="m")
        expected = egad.measure(mesh, grippers[name], max_candidates=256)
        assert tables[name].loc["A0", "graspability"] == pytest.approx(
            expected.graspability, rel=1e-6
        )
    assert tables["mine"].loc["A0", "graspability"] != tables["yumi"].loc["A0", "graspability"]
    assert pd.isna(tables["mine"].loc["B0", "graspability"])
