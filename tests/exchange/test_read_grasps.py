"""Files of grasps that other programs wrote, read again."""

import pickle
from pathlib import Path

import h5py
import numpy as np
import pytest
import trimesh
from described_hands import box_urdf
from grasp_sources import CAMERA, IDENTITY, SOURCES, change_json, hammer, labelled, write_source

import egad
from egad.errors import UserError
from egad.exchange.grasps.isaac_grasp import write_isaac_grasp


@pytest.fixture(scope="module")
def mesh():
    return hammer()


@pytest.fixture(scope="module")
def grasps(mesh):
    return egad.sample_grasps(mesh, "panda", n=40)


@pytest.mark.usefixtures("started_reader")
@pytest.mark.parametrize("name", SOURCES)
def test_poses_widths_and_labels_come_back(name, mesh, grasps, tmp_path):
    path, said = write_source(name, tmp_path, grasps)
    found = egad.read_grasps(path, mesh=mesh, gripper="panda", **said)
    if name == "simready":  # the most robust comes first
        grasps = grasps.sorted_by("robust_quality")
        assert found.source_score == pytest.approx(grasps.robust_quality, rel=1e-12)
    assert found.poses == pytest.approx(grasps.poses, abs=SOURCES[name][3])
    assert found.widths == pytest.approx(grasps.widths, abs=1e-6)
    assert found.contacts == pytest.approx(grasps.contacts, abs=1e-6)
    assert (found.collision_free == grasps.collision_free).all()
    assert found.quality == pytest.approx(grasps.quality, rel=1e-4, abs=1e-7)
    number = np.arange(len(grasps))
    labels = {"acronym": number % 3 > 0, "graspgen": number % 3 > 0, "vgn": number % 4 > 0}
    labels["simready"] = number >= 0
    if name in labels:
        assert (found.source_success == labels[name]).all()
    else:
        assert np.isnan(found.source_success).all()
    assert np.isfinite(found.source_score).all() == (
        name in ("graspnet", "contact_graspnet", "isaac_grasp", "simready")
    )


def test_isaac_files_of_a_hand_with_a_file_are_of_its_base_link(grasps, tmp_path):
    hand = egad.Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    table = labelled(grasps).assign(needed_opening=grasps.widths)
    write_isaac_grasp(tmp_path / "a.yaml", "hammer", hand, table)
    found = egad.read_grasps(tmp_path / "a.yaml", gripper=hand)
    assert found.poses == pytest.approx(grasps.poses, abs=1e-8)
    assert found.widths == pytest.approx(grasps.widths, abs=1e-6)
    assert set(found.source_score) == {0.0, 1.0}


def test_csv_of_plain_poses_names_its_columns(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("x,y,z,qx,qy,qz,qw,width,success\n10,20,30,0,0,0.7071068,0.7071068,40,1\n")
    found = egad.read_grasps(path, frame="x z", depth=0.01, units="mm")
    quarter = [[0, -1, 0, 0.01], [1, 0, 0, 0.02], [0, 0, 1, 0.04], [0, 0, 0, 1]]
    assert found.poses[0] == pytest.approx(np.array(quarter), abs=1e-6)
    assert (found.widths[0], found.source_success[0]) == (pytest.approx(0.04), 1)
    assert repr(found) == "Grasps(1 grasps, widths: 40.0 to 40.0 mm)".replace("1 grasps", "1 grasp")
    with pytest.raises(UserError, match="no quality: it is computed"):
        _ = found.quality


@pytest.mark.parametrize(
    ("name", "missing", "asked"),
    [
        ("acronym", "gripper", "how far ahead of its poses the contacts are .* give `gripper`"),
        ("graspnet", "reference", "does not say which: give `reference`, the .4, 4. pose"),
        ("contact_graspnet", "reference", "frame of the camera .* give `reference`"),
        ("vgn", "reference", "frame of a scene.* give `reference`"),
        ("isaac_grasp", "frame", "no file of its own: give `frame`, the closing axis"),
        ("poses", "depth", "where the contacts are: give `depth`"),
        ("poses", "units", "in which unit they are: give `units`, m, cm or mm"),
    ],
)
def test_what_a_file_leaves_open_is_asked_for_by_name(name, missing, asked, grasps, tmp_path):
    path, said = write_source(name, tmp_path, grasps)
    arguments = {"gripper": "panda", **said}
    del arguments[missing]
    with pytest.raises(UserError, match=asked):
        egad.read_grasps(path, **arguments)


def test_without_a_mesh_unknown_widths_are_asked_for(tmp_path):
    np.save(tmp_path / "a.npy", np.eye(4)[None])
    with pytest.raises(UserError, match="how wide grasps are: give `mesh`"):
        egad.read_grasps(tmp_path / "a.npy", frame="x z", depth=0, units="m")


def test_one_of_several_objects_is_chosen(grasps, tmp_path):
    path, _ = write_source("graspnet", tmp_path, grasps)
    rows = np.load(path)
    rows[:15, -1] = 7
    np.save(path, rows)
    with pytest.raises(UserError, match=r"several objects \(0, 7\): give `object_id`"):
        egad.read_grasps(path, reference=IDENTITY)
    assert len(egad.read_grasps(path, reference=IDENTITY, object_id=7)) == 15
    with pytest.raises(UserError, match="no grasps of '3', `object_id`; known: 0, 7"):
        egad.read_grasps(path, reference=IDENTITY, object_id=3)


BROKEN = {
    "not finite": lambda poses: poses.__setitem__((3, 0, 0), np.nan),
    "no rotation and translation": lambda poses: poses.__setitem__((3, slice(3), 0), 0.5),
    "grasp 0, and 39 more of 40": lambda poses: poses.__imul__(np.diag([1, -1, 1, 1])),
}


@pytest.mark.parametrize("message", BROKEN)
def test_matrices_that_are_no_poses_are_refused(message, grasps, tmp_path):
    poses = grasps.poses
    if message.startswith("grasp 0"):
        poses[:, :, 1] *= -1  # a mirrored hand
    else:
        BROKEN[message](poses)
    np.savez(tmp_path / "a.npz", poses=poses, widths=grasps.widths)
    with pytest.raises(UserError, match=message):
        egad.read_grasps(tmp_path / "a.npz", frame="x z", depth=0, units="m")


def test_files_of_something_else_are_refused(grasps, tmp_path):
    said = {"frame": "x z", "depth": 0, "units": "m"}
    path = tmp_path / "a.json"
    for text, message in (
        ("{", "not a file of grasps that can be read .JSONDecodeError"),
        ("[1]", "it holds a list in place of names"),
        ('{"a": 1}', "not a file of graspgen or graspgen_suction: it has a"),
        ('{"object": {}, "grasps": {"transforms": []}}', "allowed"),
    ):
        path.write_text(text)
        with pytest.raises(UserError, match=message):
            egad.read_grasps(path, depth=0.1)
    (tmp_path / "a.pkl").touch()
    with pytest.raises(UserError, match=r"ends in .h5, .hdf5, .json"):
        egad.read_grasps(tmp_path / "a.pkl")
    with pytest.raises(UserError, match="no such file"):
        egad.read_grasps(tmp_path / "b.json")
    with pytest.raises(UserError, match=r"format 'acronim' is not known.*did you mean acronym"):
        egad.read_grasps(path, "acronim")
    np.savez(tmp_path / "a.npz", poses=grasps.poses, widths=grasps.widths[:3])
    with pytest.raises(UserError, match=r"40 poses, but \(3,\) widths"):
        egad.read_grasps(tmp_path / "a.npz", **said)
    np.savez(tmp_path / "a.npz", poses=np.zeros((0, 4, 4)))
    with pytest.raises(UserError, match="it has 0 grasps; allowed: 1 to 1,000,000"):
        egad.read_grasps(tmp_path / "a.npz", **said)


class Evil:
    def __reduce__(self):
        return print, ("run",)


def test_pickled_code_is_not_run(tmp_path, capfd):
    path = tmp_path / "a.npz"
    np.savez(path, pred_grasps_cam={1: Evil()}, scores={1: [1.0]})
    assert pickle.dumps(Evil())
    with pytest.raises(UserError, match=r"pickled code .builtins.print., which is not run"):
        egad.read_grasps(path, reference=CAMERA)
    assert "run" not in capfd.readouterr().out


def test_a_million_grasps_are_refused_before_they_fill_the_memory(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        shape = (1 << 24, 4, 4)
        file.create_dataset("grasps/transforms", shape, chunks=(1 << 16, 4, 4), dtype="f8")
    with pytest.raises(UserError, match="its grasps/transforms has more than 256 MiB"):
        egad.read_grasps(path, gripper="panda")


def test_grasps_of_another_object_are_told(grasps, tmp_path):
    path, said = write_source("acronym", tmp_path, grasps)
    other = trimesh.creation.box((0.02, 0.03, 0.02)).apply_translation((-0.3, 0, 0))
    with pytest.warns(UserWarning, match="only 0% of the grasps have the object between"):
        egad.read_grasps(path, mesh=other, gripper="panda", **said)


def test_booleans_of_graspgen_may_be_numbers_but_nothing_else(grasps, tmp_path):
    path, _ = write_source("graspgen", tmp_path, grasps)
    change_json(path, lambda content: content["grasps"].update(object_in_gripper=[2] * 40))
    with pytest.raises(UserError, match="a label other than 0 and 1: grasp 0"):
        egad.read_grasps(path, gripper="panda")


# Written by the functions of their authors (`build_6d_grasp` of contact_graspnet, `write_grasp` of
# vgn, `save_to_isaac_grasp_format` of GraspGen, `GraspGroup.save_npy` of graspnetAPI) for contacts
# that are 40, 50 and 60 mm apart around these points.
POINTS = [[0.1, 0.2, 0.3], [-0.1, 0.05, 0.4], [0.02, -0.03, 0.5]]
CLOSING = [[1, 0, 0], [0, 0.6, 0.8], [0, 0, 1]]
APPROACH = [[0, 0, -1], [1, 0, 0], [0.6, 0.8, 0]]
THEIRS = {
    "predictions_7.npz": {"reference": IDENTITY},
    "grasps.csv": {"reference": IDENTITY, "depth": 0.0395},
    "isaac.yaml": {"frame": "x z", "depth": 0.10527314},
    "graspnet.npy": {"reference": IDENTITY},
}


@pytest.mark.parametrize("file", THEIRS)
def test_files_that_the_programs_of_others_wrote(file):
    balls = [trimesh.creation.icosphere(5, radius) for radius in (0.02, 0.025, 0.03)]
    mesh = trimesh.util.concatenate(
        [ball.apply_translation(at) for ball, at in zip(balls, POINTS, strict=True)]
    )
    path = Path(__file__).parents[1] / "data/grasps" / file
    found = egad.read_grasps(path, mesh=mesh, gripper="panda", **THEIRS[file])
    assert found.poses[:, :3, 3] == pytest.approx(np.array(POINTS), abs=1e-7)
    assert found.poses[:, :3, 0] == pytest.approx(np.array(CLOSING), abs=1e-7)
    assert found.poses[:, :3, 2] == pytest.approx(np.array(APPROACH), abs=1e-7)
    assert found.widths == pytest.approx(np.array([0.04, 0.05, 0.06]), abs=1e-4)
    if file == "grasps.csv":
        assert found.source_success.tolist() == [1, 1, 0]
    else:
        scores = [0.9, 0.7, 0.5] if file == "graspnet.npy" else [0.9, 0.5, 0.3]
        assert found.source_score == pytest.approx(np.array(scores))
