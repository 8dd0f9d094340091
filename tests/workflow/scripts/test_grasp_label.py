"""Labels of grasps by the stage and by the library; the palm mesh of a gripper."""

import grasp_label
import numpy as np
import pandas as pd
import pytest
import rescale
import trimesh
from partial_tables import write_rows

import egad
from egad.errors import UserError
from egad.exchange import RescaleMeshes
from egad.grasps import GraspLabel
from egad.grasps.labels import label_parameters
from egad.grasps.parameters import LabelParameters
from egad.grasps.sampling import dataset_grasps
from egad.grippers import Gripper, hand_body
from egad.io import write_obj
from egad.objects import named_meshes, scaled_solid
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings, select


def label_by_stages(folder, each, gripper, grasps, seed):
    """Grasps of a dataset of one object, which is made in a folder."""
    write_rows(OBJECTS, [{"id": each.id, "label": each.label}], folder / "objects.parquet")
    (folder / "meshes").mkdir()
    write_obj(each.mesh, folder / f"meshes/{each.label}.obj")
    settings = Settings(grasp_label=GraspLabel(grasps=grasps), seed=seed)
    scaling = select(settings, RescaleMeshes, gripper)
    rescale.run(scaling, folder / "meshes", folder / "scaled")
    grasp_label.run(
        select(settings, LabelParameters, gripper),
        folder / "objects.parquet",
        folder / "scaled",
        (0, 1),
        *(folder / f"{name}.parquet" for name in ("grasps", "sampling", "rejected")),
    )
    return parquet.read(folder / "grasps.parquet", GRASPS)


@pytest.mark.parametrize("gripper", ["panda", "yumi"])  # yumi is too small for it as it is
def test_the_library_samples_the_grasps_of_the_stage(tmp_path, gripper):
    expected = label_by_stages(tmp_path, egad.load("released")["M14_3"], gripper, 30, 5)
    assert len(expected) == 30
    (target,) = named_meshes(egad.load(tmp_path))
    hand = egad.gripper(gripper)
    mesh = scaled_solid(target, hand, "paper")
    found = dataset_grasps(mesh, target.id, label_parameters(hand, 30, 5))
    found = found.assign(id=target.id, label=target.label)[GRASPS.names]
    pd.testing.assert_frame_equal(found, expected, check_exact=True, check_dtype=False)


def test_the_mesh_of_a_gripper_is_read_in_metres(tmp_path):
    path = tmp_path / "palm.stl"
    trimesh.creation.box([0.1, 0.06, 0.05]).export(path)
    *_, palm = hand_body(Gripper(opening=0.05, mesh=str(path))).parts()
    assert np.ptp(palm.box, axis=0) == pytest.approx([0.1, 0.06, 0.05])


@pytest.mark.parametrize("content", [None, "solid nothing\n", "flat"])
def test_a_mesh_that_cannot_be_used_is_named(tmp_path, content):
    path = tmp_path / "palm.obj"
    if content == "flat":
        path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    elif content:
        path.write_text(content)
    with pytest.raises(UserError, match=r"the mesh .*palm\.obj of a gripper cannot be used: "):
        hand_body(Gripper(opening=0.05, mesh=str(path)))
