"""Usual mistakes in files of grasps: all are named, and none in files that are right."""

import re

import h5py
import numpy as np
import pytest
import trimesh
from grasp_sources import change_json, hammer, write_source
from mistakes import MISTAKES
from scipy.spatial.transform import Rotation

import egad
from egad.errors import UserError


def hook():
    """Three bars of different lengths at right angles, away from the origin."""
    sizes = [(0.11, 0.02, 0.03), (0.02, 0.07, 0.024), (0.018, 0.022, 0.06)]
    places = [(0.05, 0, 0), (0.1, 0.03, 0.002), (0.004, 0.001, 0.04)]
    bars = [
        trimesh.creation.box(size).apply_translation(place)
        for size, place in zip(sizes, places, strict=True)
    ]
    whole = trimesh.boolean.union(bars, engine="manifold")
    return whole.apply_translation((0.05, -0.03, 0.04))


def cone():
    """A frustum with a knob, along no axis of its frame."""
    bodies = [
        trimesh.creation.cylinder(0.03, 0.02).apply_translation((0, 0, -0.05)),
        trimesh.creation.cone(0.028, 0.09).apply_translation((0, 0, -0.045)),
        trimesh.creation.box((0.015, 0.09, 0.015)).apply_translation((0, 0.03, -0.04)),
    ]
    whole = trimesh.boolean.union(bodies, engine="manifold")
    turn = trimesh.transformations.rotation_matrix(1.1, (1, 0.4, 0.2), (0.1, 0, 0.05))
    return whole.apply_transform(turn).apply_translation((0.02, 0.05, 0.08))


OBJECTS = {"hammer": hammer, "hook": hook, "cone": cone}


@pytest.fixture(scope="module")
def objects():
    """Meshes with grasps at which the open hand fits."""
    meshes = {name: make() for name, make in OBJECTS.items()}
    found = {name: egad.sample_grasps(mesh, "panda", 120) for name, mesh in meshes.items()}
    return {name: (meshes[name], each[each.collision_free]) for name, each in found.items()}


def change_acronym(path, change):
    with h5py.File(path, "r+") as file:
        file["grasps/transforms"][...] = change(file["grasps/transforms"][()])


def change_graspgen(path, change):
    def changed(content):
        grasps = content["grasps"]
        grasps["transforms"] = change(np.array(grasps["transforms"])).tolist()

    change_json(path, changed)


def change_graspnet(path, change):
    """Its hand approaches along x and closes along y; `change` has z and x there."""
    rows, order = np.load(path), [1, 2, 0]
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, :3] = rows[:, 4:13].reshape(-1, 3, 3)[:, :, order]
    poses[:, :3, 3] = rows[:, 13:16]
    poses = change(poses)
    rows[:, 4:13] = poses[:, :3, :3][:, :, np.argsort(order)].reshape(-1, 9)
    rows[:, 13:16] = poses[:, :3, 3]
    np.save(path, rows)


def change_contact_graspnet(path, change):
    with np.load(path, allow_pickle=True) as file:
        content = {name: file[name][()] for name in file}
    content["pred_grasps_cam"] = {1: change(content["pred_grasps_cam"][1])}
    del content["contact_pts"]
    np.savez(path, **content)


CHANGES = {
    "acronym": change_acronym,
    "graspgen": change_graspgen,
    "graspnet": change_graspnet,
    "contact_graspnet": change_contact_graspnet,
}
# mistakes that a format cannot hold, or for which its axes have other names
OTHERS = {
    "graspnet": {
        what for what in MISTAKES if re.match("axes|rever|inv|trans|rotations|quat", what)
    },
    "contact_graspnet": {"y up", "-y up", "mirrored object"},  # of the camera
}
PAIRS = [(name, what) for name in CHANGES for what in MISTAKES if what not in OTHERS.get(name, ())]


def each_once(pairs, first, second):
    """Pairs so that every value of either is in one; the others are slow."""
    seen = set()
    for pair in pairs:
        quick = pair[first] not in seen or pair[second] not in seen
        seen |= {pair[first], pair[second]} if quick else set()
        yield pytest.param(*pair, marks=() if quick else pytest.mark.slow)


def turn(pair):
    """Every mistake in another format than the one before."""
    return (list(MISTAKES).index(pair[1]) + list(CHANGES).index(pair[0])) % len(CHANGES)


TURNS = [(number, *pair) for number, pair in enumerate(sorted(PAIRS, key=turn))]


@pytest.mark.parametrize(("number", "name", "what"), list(each_once(TURNS, 2, 2)))
def test_mistakes_are_named(number, name, what, objects, tmp_path):
    mesh, grasps = list(objects.values())[number % len(objects)]
    path, said = write_source(name, tmp_path, grasps)
    change, words = MISTAKES[what]
    CHANGES[name](path, change)
    found = egad.check_grasps(path, mesh, "panda", **said)
    assert found.verdict == "mistake", found
    assert re.search(words, found.mistakes[0]), found
    poses, near = found.corrected.poses, 0.02 if "deep" in what else 1e-6
    assert poses[:, :3, 3:] == pytest.approx(grasps.poses[:, :3, 3:], abs=near)
    assert poses[:, :3, 2] == pytest.approx(grasps.poses[:, :3, 2], abs=1e-6)


def to_center_of_mass(mesh):
    return mesh.apply_translation(-mesh.center_mass), "relative to the center of mass"


def to_middle_of_box(mesh):
    return mesh.apply_translation(-mesh.bounds.mean(axis=0)), "relative to the middle of the box"


def to_larger(mesh):
    return mesh.apply_scale(1.25), r"the object is about 0\.(7[6-9]|8[0-4]?) times as large"  # 5 %


@pytest.mark.parametrize("name", ["acronym", "graspgen", "graspnet", "poses"])
@pytest.mark.parametrize("changed", [to_center_of_mass, to_middle_of_box, to_larger])
def test_another_frame_or_size_of_the_object_is_named(changed, name, tmp_path):
    theirs, words = changed(hammer())
    grasps = egad.sample_grasps(theirs, "panda", 120)
    path, said = write_source(name, tmp_path, grasps[grasps.collision_free])
    found = egad.check_grasps(path, hammer(), "panda", **said)
    assert found.verdict == "mistake", found
    assert re.search(words, found.mistakes[0]), found


@pytest.mark.parametrize("name", ["graspnet", "poses"])
def test_widths_of_one_finger_are_named(name, objects, tmp_path):
    mesh, grasps = objects["cone"]
    path, said = write_source(name, tmp_path, grasps)
    if name == "graspnet":
        rows = np.load(path)
        rows[:, 1] /= 2
        np.save(path, rows)
    else:
        with np.load(path) as content:
            np.savez(path, poses=content["poses"], widths=content["widths"] / 2)
    found = egad.check_grasps(path, mesh, "panda", **said)
    assert found.verdict == "mistake", found
    assert found.mistakes == ["the widths are those of one finger: multiply them by 2"]


RIGHT = [(name, which) for which in OBJECTS for name in [*CHANGES, "vgn", "isaac_grasp", "poses"]]


@pytest.mark.parametrize(("name", "which"), list(each_once(RIGHT, 0, 1)))
def test_no_mistake_is_named_in_files_that_are_right(name, which, objects, tmp_path):
    mesh, grasps = objects[which]
    path, said = write_source(name, tmp_path, grasps)
    found = egad.check_grasps(path, mesh, "panda", **said)
    assert (found.verdict, found.mistakes) == ("consistent", []), found
    assert str(found).startswith("no mistake found: ")
    found.save(tmp_path / "fixed.npz")
    back = egad.read_grasps(tmp_path / "fixed.npz", mesh=mesh, gripper="panda")
    assert back.poses == pytest.approx(
        egad.read_grasps(path, mesh=mesh, gripper="panda", **said).poses
    )


def test_a_file_that_nothing_explains_is_not_written(tmp_path):
    rng, poses = np.random.default_rng(0), np.tile(np.eye(4), (60, 1, 1))
    poses[:, :3, :3] = Rotation.random(60, rng=rng).as_matrix()
    poses[:, :3, 3] = 1e5 * rng.normal(size=(60, 3))
    np.savez(tmp_path / "a.npz", poses=poses, frame="x z", depth=0.0, units="m")
    found = egad.check_grasps(tmp_path / "a.npz", trimesh.creation.box((0.04,) * 3), "panda")
    assert found.verdict == "unexplained"
    with pytest.raises(UserError, match="there is no single mistake"):
        found.save(tmp_path / "fixed.npz")


EVOLVED = ("A3", "B2", "C4", "D1", "E3", "F5", "G0")


@pytest.fixture(scope="module")
def evolved():
    """Objects of the evaluation set, some of which are symmetric, as `objects`."""
    found = {}
    for label in EVOLVED:
        mesh, _ = egad.rescale(egad.load("evaluation-set")[label].mesh, "panda")
        grasps = egad.sample_grasps(mesh, "panda", 120)
        found[label] = mesh, grasps[grasps.collision_free]
    return found


EVOLVED_RIGHT = [
    (name, label) for name in [*CHANGES, "vgn", "isaac_grasp", "poses"] for label in EVOLVED
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label"), EVOLVED_RIGHT)
def test_no_mistake_is_named_in_right_files_of_evolved_objects(name, label, evolved, tmp_path):
    mesh, grasps = evolved[label]
    path, said = write_source(name, tmp_path, grasps)
    found = egad.check_grasps(path, mesh, "panda", **said)
    assert (found.verdict, found.mistakes) == ("consistent", []), found


@pytest.mark.slow
@pytest.mark.parametrize("label", ["A3", "C4", "E3"])
@pytest.mark.parametrize(("name", "what"), PAIRS)
def test_symmetric_objects_hide_mistakes_but_none_is_named_wrongly(
    name, what, label, evolved, tmp_path
):
    change, words = MISTAKES[what]
    mesh, grasps = evolved[label]
    path, said = write_source(name, tmp_path, grasps)
    CHANGES[name](path, change)
    found = egad.check_grasps(path, mesh, "panda", **said)
    named = any(re.search(words, each) for each in found.mistakes)
    if label == "E3":  # the only one of them without a symmetry
        assert found.verdict == "mistake"
    assert named or found.verdict == "consistent", found


def test_widths_in_the_same_wrong_unit_are_corrected_too(objects, tmp_path):
    mesh, grasps = objects["hammer"]
    path, fixed = tmp_path / "grasps.npz", tmp_path / "fixed.npz"
    poses = grasps.poses
    poses[:, :3, 3] *= 1000
    np.savez(path, poses=poses, widths=1000 * grasps.widths)
    found = egad.check_grasps(path, mesh, "panda", frame="x z", depth=0, units="m")
    assert found.mistakes == ["the positions are in millimetres"]
    found.save(fixed)
    again = egad.read_grasps(fixed, frame="x z", depth=0, units="m")
    assert again.poses == pytest.approx(grasps.poses, abs=1e-9)
    assert again.widths == pytest.approx(grasps.widths, abs=1e-9)
