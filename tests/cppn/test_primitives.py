import numpy as np
import pytest
import trimesh

from egad.cppn.constraints import region_voxels, voxel_middles
from egad.errors import UserError
from egad.pipeline.config import Region


def made(resolution=20, mesh=None, **values):
    return region_voxels(Region(**values), resolution, mesh)


def test_a_full_box_is_the_cube():
    assert made(kind="box").all()


@pytest.mark.parametrize(
    ("kind", "part"), [("box", 1), ("cylinder", np.pi / 4), ("ellipsoid", np.pi / 6)]
)
def test_volumes_are_those_of_the_bodies(kind, part):
    voxels = made(kind=kind, size=(0.8, 0.5, 0.6), resolution=60)
    assert voxels.mean() == pytest.approx(part * 0.8 * 0.5 * 0.6, rel=0.02)


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
def test_bodies_fill_their_box_and_lie_where_they_should(kind):
    voxels = made(kind=kind, size=(0.5, 0.3, 0.4), centre=(0.25, 0, -0.1), axis="y")
    places = np.argwhere(voxels)
    assert places.min(axis=0).tolist() == [10, 7, 4]
    assert places.max(axis=0).tolist() == [19, 12, 11]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_cylinder_has_one_cross_section_along_its_axis(axis):
    voxels = np.moveaxis(made(kind="cylinder", axis="xyz"[axis]), axis, 0)
    assert (voxels == voxels[0]).all()
    assert 0.7 < voxels[0].mean() < 0.85


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
def test_a_mesh_of_a_body_has_the_voxels_of_the_body(kind):
    meshes = {
        "box": trimesh.creation.box(),
        "cylinder": trimesh.creation.cylinder(0.5, 1, sections=256),
        "ellipsoid": trimesh.creation.icosphere(5, 0.5),
    }
    size = np.array([0.73, 0.51, 0.62])
    mesh = meshes[kind].apply_scale(70 * size).apply_translation([1, -40, 8])
    place = {"size": tuple(size), "centre": (0.07, -0.11, 0.03)}
    of_mesh = region_voxels(Region(kind="mesh", mesh="file", **place), 31, mesh)
    of_body = region_voxels(Region(kind=kind, **place), 31)
    assert (of_mesh != of_body).sum() < 0.01 * of_body.sum()


def test_a_mesh_keeps_its_proportions():
    mesh = trimesh.creation.box((1.1, 2, 4))
    voxels = region_voxels(Region(kind="mesh", mesh="file"), 20, mesh)
    assert np.ptp(np.argwhere(voxels), axis=0).tolist() == [5, 9, 19]


def test_a_mesh_that_was_not_read_is_named():
    with pytest.raises(UserError, match=r"part\.stl"):
        region_voxels(Region(kind="mesh", mesh="part.stl"), 8)


def test_middles_are_symmetric():
    middles = voxel_middles(5)
    assert middles.shape == (125, 3)
    np.testing.assert_allclose(middles, -middles[::-1], atol=1e-15)
