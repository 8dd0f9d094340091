"""The arrays are read the way that graspnetAPI reads them, by a reader of our own."""

import numpy as np
import pandas as pd
import pytest

from egad.exchange.grasps import graspnet
from egad.exchange.grasps.graspnet import needed_friction
from egad.exchange.parameters import GripperFormat
from egad.grasps import Grasps
from egad.tables.grasping import GRASPS
from egad_workflow.settings import select

GRIPPER = "yumi"


def export(settings, grasps, out):
    graspnet.run(select(settings, GripperFormat, GRIPPER), grasps, out)
    return out


@pytest.fixture(scope="module")
def folder(dataset, settings, tmp_path_factory):
    grasps = dataset / "grasps" / f"{GRIPPER}.parquet"
    return export(settings, grasps, tmp_path_factory.mktemp("graspnet") / "out")


def read(path):
    """Columns of an array: score, width, height, depth, rotations, translations, object."""
    array = np.load(path)
    assert array.dtype == np.float64
    assert array.shape[1] == 17
    return (*array[:, :4].T, array[:, 4:13].reshape(-1, 3, 3), array[:, 13:16], array[:, 16])


def known_rows(labelled, label):
    rows = labelled[labelled["label"] == label]
    return rows[rows["simulated_success"].notna() | ~rows["collision_free"]]


def test_fingers_close_on_the_contacts_at_its_depth(folder, labelled):
    for label in ("A00_0", "B01_0"):
        rows = known_rows(labelled, label)
        _, width, height, depth, turns, places, _ = read(folder / f"{label}.npy")
        assert len(width) == len(rows) > 5
        assert np.linalg.det(turns) == pytest.approx(1)
        for number, side in ((0, -0.5), (1, 0.5)):
            local = np.stack([depth, side * rows["width"].to_numpy(), np.zeros(len(rows))], axis=1)
            found = np.einsum("nij,nj->ni", turns, local) + places
            contacts = rows[[f"contact{number}_{part}" for part in "xyz"]].to_numpy()
            assert found == pytest.approx(contacts, abs=1e-12)
        approach = rows[[f"approach_{part}" for part in "xyz"]].to_numpy()
        assert turns[:, :, 0] == pytest.approx(approach, abs=1e-12)
        assert (width >= rows["width"].to_numpy()).all()
        assert (width <= 0.05).all()
        assert (height > 0).all()


def test_scores_are_those_of_grasps_that_held(folder, labelled):
    for label in ("A00_0", "B01_0"):
        rows, score = known_rows(labelled, label), read(folder / f"{label}.npy")[0]
        held = rows["simulated_outcome"].isin(["success", "slipped_lifting", "dropped"])
        assert (score > 0).tolist() == held.tolist()
        slipping = np.arccos(np.minimum(1, _cosines(rows)))
        expected = 1.1 - np.clip(np.tan(slipping), 0.1, 1)
        assert score[held] == pytest.approx(expected[held])


def _cosines(rows):
    """The smaller cosine between the axis and the normals, which both lie outside."""
    axis = rows[[f"axis_{part}" for part in "xyz"]].to_numpy()
    sides = [
        way * np.sum(axis * rows[[f"normal{number}_{part}" for part in "xyz"]].to_numpy(), axis=1)
        for number, way in ((0, -1), (1, 1))
    ]
    return np.minimum(*sides)


def test_objects_are_numbered(folder):
    listed = pd.read_csv(folder / "objects.csv")
    assert listed["label"].tolist() == ["A00_0", "B01_0"]
    for number, label in listed.itertuples(index=False):
        assert set(read(folder / f"{label}.npy")[6]) == {number}


@pytest.mark.parametrize("degrees", [0, 10, 30, 44, 100])
def test_the_friction_that_is_needed_is_that_of_the_steeper_contact(degrees):
    angle = np.radians(degrees)
    row = dict.fromkeys(GRASPS.names, 0.0) | {"contact0_x": -0.01, "contact1_x": 0.01}
    row |= {"normal0_x": -1.0, "normal1_x": np.cos(angle), "normal1_y": np.sin(angle)}
    (found,) = needed_friction(Grasps(pd.DataFrame([row])))
    if degrees > 90:
        assert found == np.inf
    else:
        assert found == pytest.approx(np.tan(angle), abs=1e-9)
