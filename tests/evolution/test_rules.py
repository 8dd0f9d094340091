import pytest
import trimesh

from egad.errors import UserError
from egad.evolution.constraints import mesh_of


def test_a_region_is_one_body(tmp_path):
    two = [trimesh.creation.box(), trimesh.creation.box().apply_translation([3, 0, 0])]
    trimesh.util.concatenate(two).export(tmp_path / "two.stl")
    with pytest.raises(UserError, match="has 2 parts; one is allowed"):
        mesh_of(str(tmp_path / "two.stl"))
