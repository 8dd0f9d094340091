"""The files are read the way that ACRONYM's tools read them, by a reader of our own."""

import h5py
import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.errors import UserError
from egad.exchange.grasp_tables import QUALITIES, load_grasps
from egad.exchange.grasps import acronym
from egad.exchange.grasps.acronym import PANDA_REACH
from egad.exchange.parameters import AcronymFiles
from egad.geometry.mass import mass_properties
from egad.grasps.grasps import vectors
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad_workflow.settings import select

GRIPPER = "yumi"


def export(settings, dataset, out, objects=None):
    acronym.run(
        select(settings, AcronymFiles, GRIPPER),
        GRIPPER,
        objects or dataset / "objects.parquet",
        dataset / "rescaled" / GRIPPER / "scales.parquet",
        dataset / "grasps" / f"{GRIPPER}.parquet",
        out,
    )
    return out


@pytest.fixture(scope="module")
def files(dataset, settings, tmp_path_factory):
    return export(settings, dataset, tmp_path_factory.mktemp("acronym") / "files")


def read_mesh_of(path, root):
    """The mesh of a file, scaled, and what else it says of the object."""
    with h5py.File(path) as file:
        name = file["object/file"][()].decode("utf-8")
        mesh = trimesh.load(root / name, process=False)
        mesh.apply_scale(file["object/scale"][()])
        return mesh, {key: value[()] for key, value in file["object"].items()}


def read_grasps_of(path):
    with h5py.File(path) as file:
        transforms = np.array(file["grasps/transforms"])
        return transforms, np.array(file["grasps/qualities/flex/object_in_gripper"])


def known(labelled, label):
    """The grasps of an object that are simulated, or that no hand can come to."""
    rows = labelled[labelled["label"] == label]
    return rows[rows["simulated_outcome"].notna() | ~rows["collision_free"]]


def test_only_objects_with_grasps_have_a_file(files):
    assert sorted(path.name for path in files.iterdir()) == ["A00_0.h5", "B01_0.h5"]


def test_the_mesh_is_that_of_the_grasps(files, dataset, settings):
    for path in files.iterdir():
        mesh, about = read_mesh_of(path, dataset)
        scaled = trimesh.load(dataset / "rescaled" / GRIPPER / f"{path.stem}.obj", process=False)
        assert mesh.vertices == pytest.approx(scaled.vertices, abs=1e-12)
        truth = mass_properties(mesh, settings.material.density)
        assert about["density"] == pytest.approx(settings.material.density)
        for name in ("volume", "mass", "com", "inertia"):
            assert about[name] == pytest.approx(getattr(truth, name), rel=1e-9, abs=1e-12)
        assert about["friction"] == settings.quality.friction


def test_fingertips_of_its_hand_reach_beyond_the_contacts(files, dataset, labelled):
    grasps = load_grasps(dataset, GRIPPER)
    frame, poses = grasps.to_frame(), grasps.poses
    for path in files.iterdir():
        rows = known(labelled, path.stem).index
        transforms, success = read_grasps_of(path)
        assert len(transforms) == len(success) == len(rows) > 5
        assert transforms[:, :3, :3] == pytest.approx(poses[rows, :3, :3])
        tips = (transforms @ [0, 0, PANDA_REACH, 1])[:, :3]
        beyond = tips - vectors(frame, "center")[rows]
        assert beyond == pytest.approx(0.01 * vectors(frame, "approach")[rows], abs=1e-12)


def test_labels_are_those_of_the_simulation(files, labelled):
    labels = []
    for path in files.iterdir():
        rows = known(labelled, path.stem)
        _, success = read_grasps_of(path)
        held = rows["simulated_outcome"].isin(["success", "slipped_lifting", "dropped"])
        assert success.tolist() == held.astype(int).tolist()
        with h5py.File(path) as file:
            flex = {name: values[()] for name, values in file["grasps/qualities/flex"].items()}
        for name in ("linear", "angular"):
            assert np.isfinite(flex[f"object_motion_during_shaking_{name}"])[success == 1].all()
            assert (
                np.isnan(flex[f"object_motion_during_closing_{name}"]).sum()
                == (~rows["collision_free"]).sum()
            )
        labels += success.tolist()
    assert set(labels) == {0, 1}


def test_our_own_label_is_what_its_attribute_says(files, labelled):
    for path in files.iterdir():
        rows = known(labelled, path.stem)
        with h5py.File(path) as file:
            own = file["grasps/qualities/egad"]
            expected = rows["collision_free"] & (rows["robust_success_rate"] >= 0.5)
            assert own["success"][()].tolist() == expected.astype(int).tolist()
            assert "not simulated" in own["success"].attrs["meaning"]
            for name in QUALITIES:
                values = own[name][()]
                assert (values == rows[name]).all()
                assert np.isfinite(values).all()
            assert file["gripper/type"][()].decode() == GRIPPER


def test_grasps_of_an_unknown_object_are_refused(dataset, settings, tmp_path):
    rows = pd.read_parquet(dataset / "objects.parquet").iloc[1:]
    parquet.write(rows, OBJECTS, tmp_path / "objects.parquet")
    with pytest.raises(UserError, match="object 'A00_0' is not in"):
        export(settings, dataset, tmp_path / "out", tmp_path / "objects.parquet")
    assert not (tmp_path / "out").exists()
    assert list((tmp_path).glob(".*.partial")) == []
