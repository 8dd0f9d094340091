import numpy as np
import pandas as pd
import pytest

import egad
from egad.errors import TableError, UserError
from egad.exchange.grasp_tables import by_object, check_opening
from egad.tables import parquet
from egad.tables.grasping import GRASPS


def test_grasps_load_from_a_folder_and_from_a_file(dataset, labelled):
    for place in (
        (dataset, "yumi"),
        (dataset / "grasps" / "yumi.parquet",),
        (str(dataset), "yumi"),
    ):
        grasps = egad.load_grasps(*place)
        pd.testing.assert_frame_equal(grasps.to_frame(), labelled)
        assert grasps.poses.shape == (len(labelled), 4, 4)


def test_a_gripper_that_is_not_there_is_named(dataset, tmp_path):
    with pytest.raises(UserError, match="no grasps for gripper 'pinda'; available: yumi"):
        egad.load_grasps(dataset, "pinda")
    with pytest.raises(UserError, match="name a gripper; available: yumi"):
        egad.load_grasps(dataset)
    with pytest.raises(UserError, match="neither a table of grasps nor a dataset"):
        egad.load_grasps(tmp_path, "yumi")
    with pytest.raises(UserError, match="given only for the folder of a dataset, not for a file"):
        egad.load_grasps(dataset / "grasps" / "yumi.parquet", "yumi")


def test_the_opening_must_be_that_of_the_dataset(dataset, tmp_path):
    check_opening(dataset, "yumi", 0.05)
    check_opening(dataset, "yumi", 0.05 * (1 + 1e-12))
    with pytest.raises(
        UserError, match=r"opens 0\.085 m in the settings, but 0\.05 m in .*--config"
    ):
        check_opening(dataset, "yumi", 0.085)
    with pytest.raises(TableError, match="not a readable Parquet file"):
        check_opening(tmp_path, "yumi", 0.05)


def table(labels, tmp_path):
    frame = pd.DataFrame({name: [None] * len(labels) for name in GRASPS.names})
    frame["label"], frame["grasp"] = labels, range(len(labels))
    parquet.write(frame, GRASPS, tmp_path / "t.parquet")
    return tmp_path / "t.parquet"


def test_objects_come_one_after_the_other_across_batches(tmp_path, monkeypatch):
    labels = [f"{number:03d}" for number in np.repeat(range(40), 7)]
    path = table(labels, tmp_path)
    monkeypatch.setattr("egad.tables.untrusted.BATCH", 10)
    found = list(by_object(path, ["grasp"]))
    assert [label for label, _ in found] == sorted(set(labels))
    assert [rows["grasp"].tolist() for _, rows in found] == [
        list(range(7 * number, 7 * number + 7)) for number in range(40)
    ]


def test_no_grasps_are_no_objects(tmp_path):
    assert list(by_object(table([], tmp_path), ["grasp"])) == []


def test_rows_in_disorder_are_refused(tmp_path):
    with pytest.raises(UserError, match="sorted by label, but b is before a"):
        list(by_object(table(["b", "a", "b"], tmp_path), ["grasp"]))
    with pytest.raises(TableError, match="columns are missing: weight"):
        list(by_object(table(["a"], tmp_path), ["weight"]))
