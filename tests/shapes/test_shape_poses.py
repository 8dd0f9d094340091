import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.shapes.poses import stable_poses


def test_a_cube_rests_on_each_of_its_faces_alike():
    cube = trimesh.creation.box((0.04, 0.04, 0.04))
    poses = stable_poses(cube, cube.center_mass, 0.01)
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6)


def test_poses_put_the_object_on_the_table(spiky_box):
    mesh = spiky_box(3)
    poses = stable_poses(mesh, mesh.center_mass, 0.0)
    assert sum(pose.probability for pose in poses) == pytest.approx(1, abs=0.01)
    for pose in poses:
        assert np.linalg.det(pose.rotation) == pytest.approx(1)
        assert pose.rotation @ pose.rotation.T == pytest.approx(np.eye(3), abs=1e-9)
        heights = (np.asarray(mesh.vertices) - pose.point) @ pose.rotation[2]
        assert heights.min() == pytest.approx(0, abs=1e-9)
        assert (heights < 1e-6 * mesh.scale).sum() >= 3


def test_the_likely_come_first_and_the_unlikely_are_left_out():
    slab = trimesh.creation.box((0.1, 0.1, 0.01))
    everything = stable_poses(slab, slab.center_mass, 0.0)
    likely = stable_poses(slab, slab.center_mass, 0.1)
    assert (len(everything), len(likely)) == (6, 2)
    assert abs(likely[0].rotation[2, 2]) == pytest.approx(1)


def test_a_heavy_end_lies_below():
    bar = trimesh.creation.box((0.02, 0.02, 0.1))
    poses = stable_poses(bar, np.array([0.0, 0.0, -0.049]), 0.0)
    down = next(pose for pose in poses if pose.rotation[2, 2] > 0.99)
    assert down.point[2] == pytest.approx(-0.05)
    assert down.probability > 0.3


@pytest.mark.parametrize("com", [(0, 0, 0.06), (1, 1, 1), (np.nan, 0, 0)])
def test_a_centre_of_mass_that_is_not_inside_is_refused(com):
    bar = trimesh.creation.box((0.02, 0.02, 0.1))
    with pytest.raises(RejectedError, match="centre of mass is not inside"):
        stable_poses(bar, np.array(com, dtype=float), 0.0)


def test_a_flat_solid_is_refused():
    box = trimesh.creation.box((0.02, 0.03, 0.04))
    flat = trimesh.Trimesh(box.vertices * [1, 1, 0], box.faces, process=False)
    line = trimesh.Trimesh(box.vertices * [1, 0, 0], box.faces, process=False)
    for mesh in (flat, line):
        with pytest.raises(RejectedError):
            stable_poses(mesh, np.zeros(3), 0.0)


def test_a_sheet_of_no_thickness_to_speak_of_ends():
    sheet = trimesh.creation.box((0.1, 0.1, 1e-12))
    with pytest.raises(RejectedError):
        stable_poses(sheet, np.zeros(3), 0.0)
