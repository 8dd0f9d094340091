"""Meshes are scaled to the gripper that is asked for."""

import pytest
import trimesh

from egad.exchange import RescaleMeshes, rescale_files
from egad.grippers import GRIPPERS
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad_workflow.settings import Settings, select


@pytest.mark.parametrize("gripper", GRIPPERS)
def test_the_shortest_side_fits_into_every_gripper_that_comes_along(gripper, tmp_path):
    opening, fraction = GRIPPERS[gripper].opening, 0.8
    sides = {"large": (0.5, 0.4, 0.6), "small": (0.02, 0.5 * fraction * opening, 0.4)}
    for name, each in sides.items():
        trimesh.creation.box(each).export(tmp_path / f"{name}.obj")
    whole = Settings.model_validate({"rescale": {"rule": "paper", "side_fraction": 0.8}})
    settings = select(whole, RescaleMeshes, gripper)
    files = [tmp_path / f"{name}.obj" for name in sides]
    assert rescale_files(settings, files, "m", tmp_path / "out") == 0
    scales = parquet.read(tmp_path / "out" / "scales.parquet", SCALES).set_index("label")
    assert set(scales["opening"]) == {opening}
    assert scales.loc["large", "after_1"] == pytest.approx(fraction * opening)
    assert scales.loc["small", "factor"] == 1
    for name in sides:
        scaled = trimesh.load_mesh(tmp_path / "out" / scales.loc[name, "file"])
        assert min(scaled.extents) <= fraction * opening * (1 + 1e-6)
