import pytest
import trimesh

from egad.errors import UserError
from egad.exchange.palm_mesh import palm_mesh
from egad.pipeline.config import Gripper


def test_a_gripper_without_mesh_has_none():
    assert palm_mesh(Gripper(opening=0.05)) is None


def test_the_mesh_of_a_gripper_is_read_in_metres(tmp_path):
    path = tmp_path / "palm.stl"
    trimesh.creation.box([0.1, 0.06, 0.05]).export(path)
    palm = palm_mesh(Gripper(opening=0.05, mesh=str(path)))
    assert palm.extents == pytest.approx([0.1, 0.06, 0.05])


@pytest.mark.parametrize("content", [None, "solid nothing\n", "flat"])
def test_a_mesh_that_cannot_be_used_is_named(tmp_path, content):
    path = tmp_path / "palm.obj"
    if content == "flat":
        path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    elif content:
        path.write_text(content)
    with pytest.raises(UserError, match=r"the mesh .*palm\.obj of a gripper cannot be used: "):
        palm_mesh(Gripper(opening=0.05, mesh=str(path)))
