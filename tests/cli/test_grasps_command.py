"""`egad grasps`: files of other programs, checked, converted and tried."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from commands import egad as run

import egad
from egad.exchange.grasps.graspgen import graspgen_hand, start_graspgen, write_graspgen
from egad.grippers import gripper
from egad.io import write_obj
from egad.tables.grasping import MOTIONS
from egad_workflow.provenance import origin_of


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An object, and a file of GraspGen with its grasps, of which every third one fails."""
    folder = tmp_path_factory.mktemp("grasps")
    sizes, places = [(0.1, 0.02, 0.03), (0.02, 0.07, 0.024)], [(0.06, 0, 0), (0.1, 0.03, 0)]
    bars = [
        trimesh.creation.box(size).apply_translation(place)
        for size, place in zip(sizes, places, strict=True)
    ]
    mesh = trimesh.boolean.union(bars, engine="manifold")
    write_obj(mesh, folder / "bar.obj")
    table = egad.sample_grasps(mesh, "panda", 60).to_frame()
    held = np.arange(len(table)) % 3 > 0
    outcome = np.where(held, "success", "slipped_shaking")
    known = {"simulated_outcome": outcome, "simulated_success": held}
    hand = graspgen_hand("panda", gripper("panda"))
    start_graspgen(folder, hand)
    write_graspgen(folder, hand, "bar", table.assign(**known, **dict.fromkeys(MOTIONS, 0.0)))
    return folder


def common(folder):
    return "--mesh", folder / "bar.obj", "--units", "m", "--gripper", "panda"


def test_a_mistake_is_named_and_corrected(folder):
    file, fixed = folder / "grasp_data/panda/bar.json", folder / "fixed.npz"
    drawn = ("--picture", folder / "ten.svg")
    done = run("grasps", "check", file, *common(folder), "--depth", "0.001", "--fix", fixed, *drawn)
    assert done.returncode == 0, done.stderr
    assert "the poses are of the base of the hand" in done.stdout
    assert "multiply the poses of the file from the right by" in done.stdout
    picture = (folder / "ten.svg").read_text()
    assert "as read: 0% fit" in picture
    assert "corrected: " in picture
    done = run("grasps", "check", fixed, *common(folder))
    assert done.stdout.startswith("no mistake found: ")


def test_grasps_go_from_one_format_to_the_next_and_back(folder, tmp_path):
    path, read = folder / "grasp_data/panda/bar.json", {"gripper": "panda"}
    first = egad.read_grasps(path, **read)
    steps = {"acronym": "bar.h5", "graspgen": "grasp_data/panda/bar.json"}
    for name, file in steps.items():
        out = tmp_path / name
        done = run("grasps", "convert", path, *common(folder), "--to", name, "--out", out)
        assert done.returncode == 0, done.stderr
        path = out / file
        found = egad.read_grasps(path, **read)
        assert found.poses == pytest.approx(first.poses, abs=1e-6)
        assert found.widths == pytest.approx(first.widths, abs=1e-6)
        assert (found.source_success == first.source_success).all()


def test_grasps_are_tried_and_compared_with_the_labels_of_their_file(folder, tmp_path):
    """Of the grasps that hold, the file calls two of three successes."""
    file, out = folder / "grasp_data/panda/bar.json", tmp_path / "tried.csv"
    levels = ("--friction", "0.1", "--friction", "0.5", "--mass", "0.2")
    options = ("--n", "15", "--jobs", "1", "--out", out, *levels)
    done = run("grasps", "try", file, *common(folder), *options)
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(out)
    assert len(table) == 30
    assert table.groupby(["friction", "mass"]).size().to_dict() == {(0.1, 0.2): 15, (0.5, 0.2): 15}
    both = int(((table["simulated_outcome"] == "success") & (table["source_success"] == 1)).sum())
    assert f"both succeed {both}, only the label" in done.stdout
    assert "by depth, m " in done.stdout
    assert "by friction " in done.stdout
    assert "by mass" not in done.stdout
    assert "labelled" in done.stdout
    done = run("grasps", "try", file, file, *common(folder), *options)
    assert "--mesh is given 1 times; allowed: once for each file" in done.stderr
    done = run("grasps", "try", file, *common(folder), "--engine", "bullet")
    assert "engine 'bullet' is not known" in done.stderr


def test_unlabelled_grasps_and_wrong_options_are_refused(folder, tmp_path):
    np.save(tmp_path / "a.npy", np.eye(4)[None])
    said = ("--frame", "x z", "--depth", "0", "--pose-units", "m")
    out = ("--to", "acronym", "--out", tmp_path / "out")
    with pytest.warns(UserWarning, match="only 0%"):
        done = run("grasps", "convert", tmp_path / "a.npy", *common(folder), *said, *out)
    assert "acronym needs the label of each grasp" in done.stderr
    assert not (tmp_path / "out").exists()
    for missing, option in (("--frame", "--frame"), ("--pose-units", "--pose-units")):
        at = said.index(missing)
        rest = said[:at] + said[at + 2 :]
        done = run("grasps", "check", tmp_path / "a.npy", *common(folder), *rest)
        assert f": give {option}, " in done.stderr
    none = ("--reference", tmp_path / "none.txt")
    done = run("grasps", "check", tmp_path / "a.npy", *common(folder), *said, *none)
    assert "--reference" in done.stderr
    done = run(
        "grasps", "convert", tmp_path / "a.npy", *common(folder), *said, "--to", "vgn", *out[2:]
    )
    assert "format 'vgn' is not known" in done.stderr


def test_a_file_of_grasps_is_a_detector_that_knows_where_its_object_is(folder, tmp_path):
    objects = tmp_path / "objects"
    objects.mkdir()
    (objects / "bar.obj").write_bytes((folder / "bar.obj").read_bytes())
    options = ("--units", "m", "--gripper", "panda", "--rule", "none", "--jobs", "1")
    (folder / "grasp_data/panda/bar.png").touch()
    for given in (folder / "grasp_data/panda/bar.json", folder / "grasp_data/panda"):
        out = ("--attempts", "2", "--out", tmp_path / "tried.parquet")
        done = run("trials", "run", f"grasps:{given}", "--objects", objects, *options, *out)
        assert done.returncode == 0, done.stderr
        assert "success" in done.stdout
        sources = origin_of(tmp_path / "tried.parquet").sources()
        assert {path.name.rpartition(":")[2] for path, _ in sources} == {"bar.obj", "bar.json"}
    scaled = ("--rule", "paper", *options[:4])
    done = run("trials", "run", f"grasps:{given}", "--objects", objects, *scaled, *out)
    assert "with grasps of meshes it is none" in done.stderr
    np.save(tmp_path / "a.npy", np.eye(4)[None])
    done = run("trials", "run", f"grasps:{tmp_path}/a.npy", "--objects", objects, *options, *out)
    assert "`frame`" in done.stderr
    assert "`egad grasps check FILE --fix FIXED.npz` takes what" in done.stderr
    (objects / "rod.obj").write_bytes((folder / "bar.obj").read_bytes())
    done = run("trials", "run", f"grasps:{given}", "--objects", objects, *options, *out)
    assert "there are no grasps of 'rod'; there are some of bar" in done.stderr
