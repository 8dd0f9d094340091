"""The folder is read the way that GraspGen's dataset reads it, by a reader of our own."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
import yaml
from described_hands import jaw_urdf

from egad import Gripper
from egad.exchange.grasps import graspgen
from egad.exchange.grasps.graspgen import (
    default_split,
    graspgen_hand,
    start_graspgen,
    write_graspgen,
)
from egad.exchange.parameters import GripperFormat
from egad.geometry.distance import nearest
from egad.grippers import GRIPPERS, model_of
from egad_workflow.settings import select

GRIPPER = "yumi"


def export(settings, dataset, out, grasps=None):
    graspgen.run(
        select(settings, GripperFormat, GRIPPER),
        GRIPPER,
        dataset / "rescaled" / GRIPPER,
        grasps or dataset / "grasps" / f"{GRIPPER}.parquet",
        out,
    )
    return out


@pytest.fixture(scope="module")
def folder(dataset, settings, tmp_path_factory):
    return export(settings, dataset, tmp_path_factory.mktemp("graspgen") / "out")


def read(folder, name=GRIPPER):
    """The objects of both lists as GraspGen's dataset has them, by the lines of the lists."""
    files = [json.loads(path.read_text()) for path in (folder / "grasp_data" / name).glob("*.json")]
    by_file = {each["object"]["file"]: each for each in files}
    found = {}
    for split in ("train", "valid"):
        for line in (folder / "splits" / name / f"{split}.txt").read_text().splitlines():
            assert line not in found
            mesh = trimesh.load(folder / "objects" / line, process=False)
            mesh.apply_scale(by_file[line]["object"]["scale"])
            grasps = by_file[line]["grasps"]
            assert {type(value) for value in grasps["object_in_gripper"]} <= {bool}
            found[line] = SimpleNamespace(
                split=split,
                mesh=mesh,
                poses=np.array(grasps["transforms"]),
                mask=np.array(grasps["object_in_gripper"], dtype=bool),
                contacts=np.array(grasps["contact_locations"]),
            )
    return found


def seen_by_hand(one):
    """The contacts in the frame of the base of the hand, (n, 2, 3)."""
    assert np.linalg.det(one.poses[:, :3, :3]) == pytest.approx(1)
    points = np.concatenate([one.contacts, np.ones((len(one.contacts), 2, 1))], axis=2)
    return np.einsum("nij,nkj->nki", np.linalg.inv(one.poses), points)[:, :, :3]


def test_contacts_lie_before_the_hand_on_its_closing_axis(folder, labelled):
    about = yaml.safe_load((folder / f"gripper/{GRIPPER}.yaml").read_text())
    for line, one in read(folder).items():
        rows = labelled[labelled["label"] == line.removesuffix(".obj")]
        known = rows[rows["simulated_success"].notna() | ~rows["collision_free"]]
        assert len(one.poses) == len(known) > 5
        half = known["width"].to_numpy() / 2
        expected = np.zeros((len(known), 2, 3))
        expected[:, 0, 0], expected[:, 1, 0], expected[:, :, 2] = -half, half, about["depth"]
        assert seen_by_hand(one) == pytest.approx(expected, abs=1e-8)


def test_contacts_lie_on_the_mesh_and_the_fingers_outside(folder):
    hand = trimesh.load(folder / f"gripper/{GRIPPER}.obj", process=False)
    for one in read(folder).values():
        assert nearest(one.contacts.reshape(-1, 3), one.mesh)[0].max() < 1e-6
        for pose in one.poses[one.mask]:
            corners = trimesh.transform_points(hand.vertices, pose)
            assert not one.mesh.contains(corners).any()


def test_the_mesh_of_the_hand_begins_at_its_base(folder):
    hand = trimesh.load(folder / f"gripper/{GRIPPER}.obj", process=False)
    about = yaml.safe_load((folder / f"gripper/{GRIPPER}.yaml").read_text())
    low, high = hand.bounds
    assert low[2] == pytest.approx(0, abs=1e-9)
    assert high[2] == pytest.approx(about["depth"] + 0.01)  # half a finger's width
    assert about["width"] == GRIPPERS[GRIPPER].opening
    assert about["transform_offset_from_asset_to_graspgen_convention"] == [[0, 0, 0], [0, 0, 0, 1]]
    compile((folder / f"gripper/{GRIPPER}.py").read_text(), "hand", "exec")


def test_success_is_that_of_the_simulation(folder, labelled):
    for line, one in read(folder).items():
        rows = labelled[labelled["label"] == line.removesuffix(".obj")]
        known = rows[rows["simulated_success"].notna() | ~rows["collision_free"]]
        held = known["simulated_outcome"].isin(["success", "slipped_lifting", "dropped"])
        assert one.mask.tolist() == held.tolist()
        assert not one.mask[~known["collision_free"].to_numpy()].any()


def test_a_list_can_be_chosen(labelled, tmp_path):
    hand = graspgen_hand("panda", GRIPPERS["panda"])
    assert hand.depth == 0.10527314
    start_graspgen(tmp_path, hand)
    for label, split in (("A00_0", "valid"), ("B01_0", "train")):
        rows = labelled[labelled["label"] == label]
        write_graspgen(tmp_path, hand, label, rows, split)
    lists = tmp_path / "splits/panda"
    assert (lists / "valid.txt").read_text() == "A00_0.obj\n"
    assert (lists / "train.txt").read_text() == "B01_0.obj\n"


def test_about_one_object_in_ten_is_for_validation():
    splits = [default_split(f"object {number}") for number in range(2000)]
    assert 150 < splits.count("valid") < 250


def test_a_fixed_jaw_is_at_the_first_contact_of_each_grasp(labelled, tmp_path):
    """So the hand is not its own mirror image, and GraspGen must not turn its grasps over."""
    gripper = Gripper.from_file(jaw_urdf(tmp_path / "jaw.urdf"))
    hand = graspgen_hand("jaw", gripper)
    start_graspgen(tmp_path, hand)
    write_graspgen(tmp_path, hand, "A00_0", labelled[labelled["label"] == "A00_0"])
    (tmp_path / "objects/A00_0.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (one,) = read(tmp_path, "jaw").values()
    contacts = seen_by_hand(one)
    closed = model_of(gripper).openings[0]
    wide = np.linalg.norm(one.contacts[:, 1] - one.contacts[:, 0], axis=1) > closed
    assert contacts[wide, 0, 0] == pytest.approx(-closed / 2, abs=1e-8)
    assert contacts[:, :, 2] == pytest.approx(hand.depth, abs=1e-8)
    about = yaml.safe_load((tmp_path / "gripper/jaw.yaml").read_text())
    assert not about["symmetric_antipodal"]


def test_objects_that_are_left_out_are_logged(dataset, settings, labelled, tmp_path, caplog):
    rows = labelled.assign(simulated_outcome="missed", simulated_success=False)
    grasps = tmp_path / "grasps.parquet"
    rows.to_parquet(grasps)
    export(settings, dataset, tmp_path / "out", grasps)
    assert "A00_0 has 0 grasps that hold; GraspGen leaves out objects with fewer than 5" in (
        caplog.text
    )
