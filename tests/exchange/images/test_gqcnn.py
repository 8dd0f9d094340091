"""Image sets as tensors, opened by GQ-CNN's own `autolab_core.TensorDataset`."""

import json
from dataclasses import replace

import numpy as np
import pytest
from autolab_core import TensorDataset
from scipy.spatial.transform import Rotation

from egad.errors import UserError
from egad.exchange.images import gqcnn
from egad.grippers import GRIPPERS

GRIPPER = GRIPPERS["panda"]
STEPS = np.meshgrid(*2 * [3 * (np.arange(32) - 15.5)])  # from the center, pixels of the image


def write_set(pictures, folder):
    folder.mkdir()
    return gqcnn.write(pictures, GRIPPER, folder)


def test_gqcnn(sets, contacts, check_rectangle, tmp_path):
    """Read by what GQ-CNN's trainer reads with."""
    chosen = sets["dexnet"]
    rows = write_set(chosen, tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    assert dataset.num_datapoints == rows == sum(len(p.grasps.u) for p in chosen)
    by_image = {p.image: p for p in chosen}
    train, validation, _ = dataset.split("object")
    assert not set(train) & set(validation)
    place = dict.fromkeys(by_image, 0)
    for index in range(rows):
        row = dataset[index]
        picture = by_image[int(row["image_labels"])]
        split = "train" if index in train else "validation" if index in validation else "test"
        assert picture.split == split
        number = place[picture.image]
        place[picture.image] += 1
        hand = row["hand_poses"]
        ends = contacts(picture)[number]
        check_rectangle(hand[:2], -hand[3], hand[6], ends, picture, hand[2])
        check_row(row, picture, number)
        check_camera(row, picture)
        check_cut(row, picture)
    maps = json.loads((tmp_path / "set/object_category_map.json").read_text())
    assert maps == {"A1": 0, "B2": 1, "C3": 2}


def check_row(row, picture, number):
    """The numbers of a row against its grasp."""
    grasps, hand = picture.grasps, row["hand_poses"]
    free = bool(grasps.collision_free[number])
    assert bool(row["collision_free"]) == free
    expected = grasps.quality[number] if free else 0
    assert row["robust_ferrari_canny"] == pytest.approx(expected, rel=1e-6)
    expected = [values[number] for values in (grasps.v, grasps.u, grasps.depth_center)]
    assert hand[:3] == pytest.approx(expected)
    center = picture.view.intrinsics.center
    assert hand[4:6] == pytest.approx(hand[:2] - np.array(center)[::-1], abs=1e-3)
    assert 0 <= hand[3] < 2 * np.pi + 1e-6


def check_camera(row, picture):
    """The camera of a row is that of the picture."""
    position, quaternion = np.split(row["camera_poses"], [3])
    pose, camera = picture.view.pose, picture.view.intrinsics
    np.testing.assert_allclose(position, pose[:3, 3], atol=1e-6)
    turn = Rotation.from_quat(quaternion).as_matrix()
    np.testing.assert_allclose(turn, pose[:3, :3], atol=1e-6)
    assert row["camera_intrs"] == pytest.approx([camera.focal, camera.focal, *camera.center])


def check_cut(row, picture):
    """Each pixel is between the four of the picture about its place; the axis is along x."""
    hand = row["hand_poses"].astype(float)
    cosine, sine = np.cos(hand[3]), np.sin(hand[3])
    v = np.floor(hand[0] + sine * STEPS[0] + cosine * STEPS[1]).astype(int)
    u = np.floor(hand[1] + cosine * STEPS[0] - sine * STEPS[1]).astype(int)
    mask = np.where(picture.mask, 255, 0)
    for name, image in (("depth_ims_tf_table", picture.depth), ("obj_masks", mask)):
        found = row[name][..., 0]
        around = np.array([image[v + i, u + j] for i in (0, 1) for j in (0, 1)])
        assert (around.min(axis=0) - 1e-4 < found).all()
        assert (found < around.max(axis=0) + 1e-4).all()
    assert set(np.unique(row["obj_masks"])) == {0, 255}


@pytest.mark.parametrize("size", [1, 2, 5])
def test_files_continue_each_other(sets, tmp_path, monkeypatch, size):
    monkeypatch.setattr(gqcnn, "FILE", size)
    rows = write_set(sets["dexnet"], tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    assert (dataset.num_tensors, dataset.num_datapoints) == (-(-rows // size), rows)
    images = [p.image for p in sets["dexnet"] for _ in p.grasps.u]
    assert [int(dataset[index]["image_labels"]) for index in range(rows)] == images


def test_missing_depths_are_filled(sets, tmp_path):
    write_set(sets["noisy"], tmp_path / "set")
    dataset = TensorDataset.open(str(tmp_path / "set"))
    for index in range(dataset.num_datapoints):
        assert dataset[index]["depth_ims_tf_table"].min() > 0.4


def test_tensors_need_a_grasp(sets, tmp_path):
    none = [replace(each, grasps=each.grasps.chosen(np.arange(0))) for each in sets["d435"]]
    with pytest.raises(UserError, match="no reachable grasps"):
        write_set(none, tmp_path / "set")
