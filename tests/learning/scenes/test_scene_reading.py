"""Scenes survive their files; what is missing or does not belong together is told."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest

import egad
from egad.detectors import fuse
from egad.errors import TableError, UserError
from egad.learning.images import pose_matrix
from egad.learning.scenes import load_scenes
from egad.tables import parquet
from egad.tables.scenes import SCENE_GRASPS, SCENES


def test_the_index_lists_all_scenes(dataset, made):
    index = dataset.index
    assert list(index["scene"]) == [0, 1, 2, 3]
    assert list(index["kind"]) == [each.scene["kind"] for each in made]
    assert list(index["split"]) == ["train", "train", "validation", "test"]
    assert [list(ids) for ids in index["objects"]] == [each.scene["objects"] for each in made]
    assert list(index["noise"]) == [each.scene["noise"] for each in made]
    assert list(index["views"]) == [6] * 4
    assert list(index["grasps"]) == [8] * 4
    assert list(index["positive"]) == [int(each.grasps["success"].sum()) for each in made]
    assert list(index.index) == list(range(4))
    np.testing.assert_array_equal(dataset.indices("train"), [0, 1])
    assert len(dataset) == 4
    assert repr(dataset).startswith("SceneDataset(4 scenes, 32 grasps, ")
    assert repr(dataset.scene(0)).startswith("LabelledScene(packed, ")
    assert repr(dataset.scene(0)).endswith(" of 8 grasps held)")
    assert "packed" in dataset._repr_html_()
    assert "success" in dataset.scene(0)._repr_html_()


def test_scenes_survive_the_files(dataset, made):
    for number, before in enumerate(made):
        scene = dataset.scene(number)
        row = before.scene
        assert (scene.number, scene.kind, scene.split) == (number, row["kind"], row["split"])
        assert (scene.noise, list(scene.objects)) == (row["noise"], row["objects"])
        assert list(scene.factors) == row["factors"]
        for found, values in zip(
            scene.placements, np.reshape(row["placements"], (-1, 7)), strict=True
        ):
            np.testing.assert_allclose(found, pose_matrix(values), atol=1e-12)
        pd.testing.assert_frame_equal(scene.grasps, before.grasps, check_dtype=False)
        assert len(scene.views) == scene.view_count == 6
        for view in scene.views:
            assert view.depth.shape == view.mask.shape == (row["height"], row["width"])
            assert set(np.unique(view.mask)) <= set(range(len(scene.objects) + 1))
        first = scene.grasps.iloc[0]
        np.testing.assert_allclose(scene.poses[0, :3, 3], first[["x", "y", "z"]].astype(float))
        assert scene.poses.shape == (8, 4, 4)


def test_an_observation_is_of_the_chosen_views(dataset):
    scene = dataset.scene(1)
    seen = scene.observation([4, 2])
    for view, number in zip(seen.views, (4, 2), strict=True):
        np.testing.assert_array_equal(view.depth, scene.views[number].depth)
    whole = scene.observation()
    corner = np.array([-0.15, -0.15, -0.05])
    expected = fuse(scene.views, corner, 0.3, 40)
    np.testing.assert_array_equal(whole.tsdf.distances, expected.distances)
    assert len(whole.cloud.points) > len(seen.cloud.points) > 0
    for wrong in ([], [6], [-1]):
        with pytest.raises(UserError, match="allowed: some of the numbers 0 to 5"):
            scene.observation(wrong)


def test_threads_and_processes_read_the_same(dataset):
    again = pickle.loads(pickle.dumps(dataset))  # noqa: S301 (our own)
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda number: dataset.scene(number % 4).views[0], range(16)))
    for number, view in enumerate(found):
        np.testing.assert_array_equal(view.depth, again.scene(number % 4).views[0].depth)


def test_folders_are_one_set(write, tmp_path):
    first, second = write([0, 1], folder=tmp_path / "a"), write([2, 3], folder=tmp_path / "b")
    both = load_scenes([first, second])
    assert list(both.index["scene"]) == [0, 1, 2, 3]
    assert both.scene(3).number == 3
    assert both.source == f"{first}, {second}"
    assert str(both).startswith("SceneDataset(")


def test_an_object_in_two_splits_is_refused(write, made, tmp_path):
    other = [each._replace(scene=each.scene | {"split": "test"}) for each in made]
    first = write([0, 1], folder=tmp_path / "a")
    second = write([0], scenes=other, folder=tmp_path / "b")
    with pytest.raises(UserError, match="is in more than one split"):
        load_scenes([first, second])
    unknown = [each._replace(scene=each.scene | {"split": "dev"}) for each in made]
    with pytest.raises(UserError, match="the split 'dev' is none of"):
        load_scenes(write([0], scenes=unknown, folder=tmp_path / "c"))


def test_folders_that_are_no_set_are_refused(write, tmp_path):
    with pytest.raises(UserError, match="no scenes found; make them with"):
        load_scenes(tmp_path)
    write([0, 1], [2, 3])
    (tmp_path / "grasps-1.parquet").unlink()
    with pytest.raises(UserError, match=r"incomplete, grasps-1\.parquet of 2 shards missing"):
        load_scenes(tmp_path)
    notes = parquet.notes(tmp_path / "grasps-0.parquet")
    other = notes | {"set": "another", "shard": 1}
    parquet.write(parquet.empty(SCENE_GRASPS), SCENE_GRASPS, tmp_path / "grasps-1.parquet", other)
    with pytest.raises(UserError, match="of several sets"):
        load_scenes(tmp_path)


def test_scenes_of_an_unknown_gripper_are_refused(write, dataset, settings, tmp_path):
    assert (dataset.gripper_name, dataset.gripper) == ("panda", settings.gripper)
    folder = write([0, 1], folder=tmp_path / "other")
    path, other = folder / "scenes-0.parquet", folder / "grasps-0.parquet"
    notes = parquet.notes(path)
    for wrong, error, said in (
        ({"gripper": 3}, UserError, "does not say for which gripper it is; make the scenes again"),
        ({"hand": {"opening": -1}}, TableError, "its gripper is not valid: .*opening"),
    ):
        for file, schema in ((path, SCENES), (other, SCENE_GRASPS)):
            parquet.write(parquet.read(file, schema), schema, file, notes | wrong)
        with pytest.raises(error, match=said):
            load_scenes(folder)


def test_tables_of_another_layout_are_refused(write, tmp_path):
    write([0, 1])
    path = tmp_path / "scenes-0.parquet"
    notes = parquet.notes(path)
    table = parquet.read(path, SCENES)
    parquet.write(table, SCENES.remove(SCENES.names.index("mask")), path, notes)
    with pytest.raises(TableError, match="columns are missing: mask"):
        load_scenes(tmp_path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(TableError):
        load_scenes(tmp_path)


def test_damaged_pictures_are_told(write, made, tmp_path):
    row = made[0].scene
    bad = [made[0]._replace(scene=row | {"depth": [b"no PNG", *row["depth"][1:]]})]
    scene = load_scenes(write([0], scenes=bad, folder=tmp_path / "a")).scene(0)
    with pytest.raises(TableError, match="its depth cannot be read"):
        scene.observation([0])
    assert scene.observation([1]).tsdf.weights.any()
    short = [made[0]._replace(scene=row | {"mask": row["mask"][1:]})]
    dataset = load_scenes(write([0], scenes=short, folder=tmp_path / "b"))
    with pytest.raises(TableError, match="scene 0: its lists of views are of unequal lengths"):
        dataset.scene(0)


def test_what_is_not_there(dataset):
    with pytest.raises(UserError, match="split"):
        dataset.indices("dev")
    for number in (-1, 4):
        with pytest.raises(IndexError):
            dataset.scene(number)
    with pytest.raises(UserError, match="allowed: a path"):
        egad.load_scenes([3])


def test_noise_of_points_is_the_same_each_time(write, made):
    noisy = [each._replace(scene=each.scene | {"noise": "points"}) for each in made]
    scene = load_scenes(write([0], scenes=noisy)).scene(0)
    clouds = [scene.observation().cloud.points for _ in range(2)]
    np.testing.assert_array_equal(*clouds)
    assert scene.observation().point_sigma > 0


def test_scenes_without_grasps_are_kept(write, made):
    bare = [each._replace(grasps=each.grasps.iloc[:0]) for each in made]
    dataset = load_scenes(write([0, 1], [2], scenes=bare))
    assert list(dataset.index["grasps"]) == [0, 0, 0]
    assert dataset.scene(2).poses.shape == (0, 4, 4)
