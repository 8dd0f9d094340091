"""The database is read the way Dex-Net's own classes read it, by a reader of our own."""

import itertools
import shutil
import time

import h5py
import numpy as np
import pytest
from autolab_core import RigidTransform

import egad
from egad.errors import RejectedError, UserError
from egad.exchange import DexNetObjects
from egad.exchange.dexnet_database import write_objects
from egad.exchange.grasps import dexnet
from egad.exchange.parameters import DexNetDatabase
from egad.grasps import Grasps
from egad.io import read_mesh
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad_workflow.settings import select
from egad_workflow.shards import rows_in_shard

GRIPPER = "yumi"


def export(settings, dataset, folder, shards):
    """Write the database of a dataset, cut into shards."""
    parts = [folder / f"part-{shards}-{shard}.hdf5" for shard in range(shards)]
    objects, scaled = dataset / "objects.parquet", dataset / "rescaled" / GRIPPER
    for shard, part in enumerate(parts):
        wanted = select(settings, DexNetObjects)
        rows = rows_in_shard(parquet.read(objects, OBJECTS), shard, shards)
        write_objects(wanted, parquet.records(rows), scaled, part)
    return joined(settings, dataset, parts, folder / f"database-{shards}.hdf5")


def joined(settings, dataset, parts, out):
    wanted, grasps = (
        select(settings, DexNetDatabase, GRIPPER),
        dataset / "grasps" / f"{GRIPPER}.parquet",
    )
    dexnet.run(wanted, dataset, GRIPPER, parts, grasps, out)
    return out


@pytest.fixture(scope="module")
def database(dataset, tmp_path_factory, settings):
    return export(settings, dataset, tmp_path_factory.mktemp("dexnet"), 1)


@pytest.fixture
def objects(database):
    with h5py.File(database) as file:
        yield file["datasets"]["tiny"]["objects"]


def read_grasps(group):
    """(id, configuration, metrics) of each grasp; of another type or incomplete raises."""
    found = []
    for number in range(group.attrs["num_grasps"]):
        grasp = group[f"grasp_{number}"]
        assert grasp.attrs["type"] == "ParallelJawPtGrasp3D"  # a str, not bytes
        assert grasp.attrs["frame"] == "object"
        assert grasp.attrs["id"] == number
        configuration = grasp.attrs["configuration"]
        assert (configuration.shape, configuration.dtype) == ((10,), np.float64)
        assert np.linalg.norm(configuration[3:6]) == pytest.approx(1, abs=1e-5)
        found.append((grasp.attrs["id"], configuration, dict(grasp["metrics"].attrs)))
    return found


def read_field(group):
    """Values, origin and spacing, as a reader that looks for the surface wants them."""
    data = np.array(group["data"])
    assert data.ndim == 3
    assert np.isscalar(group.attrs["resolution"])
    assert (np.abs(data) < group.attrs["resolution"] * np.sqrt(2) / 2).any()
    return data, group.attrs["origin"], group.attrs["resolution"]


def test_all_objects_are_there(objects, dataset, settings):
    assert list(objects) == ["A00_0", "B01_0", "C02_0"]
    for key, group in objects.items():
        mesh = read_mesh(dataset / "rescaled" / GRIPPER / f"{key}.obj", "m")
        assert (group["mesh"]["vertices"][()] == mesh.vertices).all()
        assert (group["mesh"]["triangles"][()] == mesh.faces).all()
        assert group["mesh"]["vertices"].dtype == np.float64
        assert group.attrs["mass"] == pytest.approx(mesh.volume * settings.material.density)
        assert group.attrs["id"] == f"id-{key}"


def test_measures_are_attributes_and_metadata(objects):
    described = objects.parent["metadata"]
    expected = {
        "complexity": 1.5,
        "graspability": 0.002,
        "diversity": 0.25,
        "complexity_cell": 3.0,
        "difficulty_cell": 14.0,
    }
    assert set(described) == set(expected)
    for name, value in expected.items():
        assert described[name].attrs["type"] == "float"
        assert isinstance(described[name].attrs["description"], str)
        for group in objects.values():
            for place in (group, group["mesh"]["metadata"]):
                assert place.attrs[name] == value
                assert place.attrs[name].dtype == np.float64


def test_grasps_are_those_of_the_table(objects, labelled):
    for key in ("A00_0", "B01_0"):
        rows = labelled[labelled["label"] == key].reset_index(drop=True)
        found = read_grasps(objects[key]["grasps"][GRIPPER])
        assert len(found) == len(rows) > 5
        for (_, configuration, metrics), row in zip(found, rows.itertuples(), strict=True):
            assert configuration[:3] == pytest.approx([row.center_x, row.center_y, row.center_z])
            assert configuration[3:6] == pytest.approx([row.axis_x, row.axis_y, row.axis_z])
            assert configuration[6] == 0.05
            assert metrics == {name: getattr(row, own) for name, own in dexnet.METRICS.items()}
            assert {value.dtype for value in metrics.values()} == {np.dtype(np.float64)}
            assert np.isfinite(list(metrics.values())).all()


@pytest.mark.parametrize("key", ["A00_0", "B01_0"])
def test_grasps_are_read_again_as_they_were(key, database, labelled, dataset):
    rows = labelled[labelled["label"] == key]
    mesh = read_mesh(dataset / "rescaled" / GRIPPER / f"{key}.obj", "m")
    found = egad.read_grasps(database, mesh=mesh, gripper=GRIPPER, object_id=f"{key}/{GRIPPER}")
    assert found.poses == pytest.approx(Grasps(rows).poses, abs=1e-9)
    assert found.widths == pytest.approx(rows["width"].to_numpy(), abs=1e-6)
    assert (found.source_score == rows["robust_quality"]).all()
    assert np.isnan(found.source_success).all()
    with pytest.raises(UserError, match=r"several objects or grippers .A00_0/yumi, B01_0/yumi"):
        egad.read_grasps(database, gripper=GRIPPER)


def test_grasps_that_dexnet_describes_are_where_its_classes_put_them(tmp_path):
    """`rotated_full_axis` of `ParallelJawPtGrasp3D`: x approaches, y is the axis."""
    axis, angle = np.array([0.48, 0.6, 0.64]), 0.7
    level = np.array([axis[1], -axis[0], 0]) / np.hypot(*axis[:2])
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = np.c_[[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]
    expected = np.stack([level, axis, np.cross(level, axis)], axis=1) @ turned
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        grasp = file.create_group("datasets/d/objects/o/grasps/g/grasp_0")
        grasp.attrs["configuration"] = [0.01, 0.02, 0.03, *axis, 0.05, angle, 0.01, 0.0]
        grasp.attrs["id"] = 0
        grasp.create_group("metrics").attrs["robust_ferrari_canny"] = 0.002
        file["datasets/d/objects/o/grasps/g"].attrs["num_grasps"] = 1
        file.create_group("datasets/d/objects/without_grasps")
    found = egad.read_grasps(tmp_path / "a.hdf5")
    assert found.poses[0, :3, 3] == pytest.approx(np.array([0.01, 0.02, 0.03]))
    assert found.poses[0, :3, 0] == pytest.approx(expected[:, 1])
    assert found.poses[0, :3, 2] == pytest.approx(expected[:, 0])
    assert (found.widths[0], found.source_score[0]) == (0.05, 0.002)


def test_only_the_chosen_object_is_read_and_datasets_are_told_apart(tmp_path):
    path = tmp_path / "a.hdf5"
    with h5py.File(path, "w") as file:
        for number, dataset in enumerate("de"):
            grasp = file.create_group(f"datasets/{dataset}/objects/o/grasps/g/grasp_0")
            grasp.attrs["configuration"] = [number, 0, 0, 0, 1, 0, 0.05, 0, 0, 0]
            grasp.attrs["id"] = 0
            grasp.create_group("metrics")
        file.create_group("datasets/e/objects/broken/grasps/g/grasp_0")
    with pytest.raises(UserError, match=r"objects or grippers .d/o/g, e/broken/g, e/o/g."):
        egad.read_grasps(path)
    found = [egad.read_grasps(path, object_id=f"{name}/o/g") for name in "de"]
    assert [each.poses[0, 0, 3] for each in found] == [0, 1]
    with pytest.raises(UserError, match="not a file of grasps that can be read"):
        egad.read_grasps(path, object_id="e/broken/g")


def test_an_object_without_grasps_has_none(objects):
    assert read_grasps(objects["C02_0"]["grasps"][GRIPPER]) == []


def test_contacts_lie_on_the_surface_of_the_field(objects, labelled):
    data, origin, resolution = read_field(objects["B01_0"]["sdf"])
    rows = labelled[labelled["label"] == "B01_0"]
    for name in ("contact0", "contact1"):
        contacts = rows[[f"{name}_{part}" for part in "xyz"]].to_numpy()
        nearest = np.round((contacts - origin) / resolution).astype(int)
        assert np.abs(data[tuple(nearest.T)]).max() < resolution * np.sqrt(3) / 2
    centers = rows[["center_x", "center_y", "center_z"]].to_numpy()
    nearest = np.round((centers - origin) / resolution).astype(int)
    assert data[tuple(nearest.T)].max() < 0


def test_stable_poses_turn_the_object_onto_the_table(objects):
    for group in objects.values():
        poses = group["stable_poses"]
        count = poses.attrs["num_stable_poses"]
        chances = [poses[f"pose_{number}"].attrs["p"] for number in range(count)]
        assert sum(chances) <= 1 + 1e-9
        for number in range(count):
            pose = poses[f"pose_{number}"]
            rotation, point = pose.attrs["r"], pose.attrs["x0"]
            table = RigidTransform(rotation, -rotation @ point, "obj", "table")
            placed = table.rotation @ group["mesh"]["vertices"][()].T + table.translation[:, None]
            assert placed[2].min() == pytest.approx(0, abs=1e-9)


def test_metrics_say_how_they_are_computed(objects):
    metrics = objects.parent["metrics"]
    assert set(metrics) == set(dexnet.METRICS)
    assert "nor on its straight approach" in metrics["collision_free"].attrs["description"]
    assert metrics["needed_opening"].attrs["description"].endswith("(m)")
    assert metrics["ferrari_canny"].attrs["torque_scaling"] == 100
    assert not metrics["ferrari_canny"].attrs["check_approach"]
    robust = metrics["robust_ferrari_canny"]
    assert not robust.attrs["check_approach"]
    assert robust.attrs["sampling_snapshot_rate"] == 3
    assert robust["params_uncertainty"].attrs["sigma_friction_coef"] == 0.1
    assert (robust.attrs["torque_scaling"], robust.attrs["num_quality_samples"]) == (1000, 3)
    assert robust["obj_uncertainty"].attrs["sigma_obj_com"] == 0.01
    assert isinstance(robust.attrs["quality_method"], str)
    assert isinstance(objects.file.attrs["time_created"], str)


def test_neither_shards_nor_time_leave_a_trace(dataset, database, tmp_path, settings):
    time.sleep(1.1)
    assert export(settings, dataset, tmp_path, 3).read_bytes() == database.read_bytes()


def test_a_damaged_part_is_named_and_kept(dataset, tmp_path, settings):
    export(settings, dataset, tmp_path, 2)
    parts = [tmp_path / f"part-2-{shard}.hdf5" for shard in range(2)]
    for part, cut in itertools.product(parts, (0, 1, 2000)):
        whole = part.read_bytes()
        part.write_bytes(whole[: len(whole) - cut] if cut else b"")
        with pytest.raises(UserError, match=rf"{part.name}: truncated or damaged .* delete it"):
            joined(settings, dataset, parts, tmp_path / "out.hdf5")
        part.write_bytes(whole)
    assert not (tmp_path / "out.hdf5").exists()


def test_a_damaged_part_of_the_workflow_is_removed(dataset, tmp_path, settings):
    copied = shutil.copytree(dataset, tmp_path / "tiny")
    part = copied / "parts" / f"exchange-{GRIPPER}-0.hdf5"
    part.parent.mkdir()
    part.write_bytes(b"half")
    with pytest.raises(UserError, match="it was removed, and the next run of snakemake"):
        joined(settings, copied, [part], tmp_path / "out.hdf5")
    assert not part.exists()


def test_an_object_that_comes_twice_is_refused(dataset, tmp_path, settings):
    export(settings, dataset, tmp_path, 1)
    part = tmp_path / "part-1-0.hdf5"
    with pytest.raises(UserError, match=r"object 'A00_0' is in .*0\.hdf5 and again in .*0\.hdf5"):
        joined(settings, dataset, [part, part], tmp_path / "out.hdf5")


def test_an_object_without_stable_poses_is_written(
    dataset, tmp_path, settings, monkeypatch, caplog
):
    def none(*_):
        raise RejectedError("its center of mass is not inside its convex hull")

    monkeypatch.setattr("egad.exchange.dexnet_database.resting_poses", none)
    with h5py.File(export(settings, dataset, tmp_path, 1)) as file:
        group = file["datasets/tiny/objects/A00_0"]
        assert group["stable_poses"].attrs["num_stable_poses"] == 0
        assert group["grasps"][GRIPPER].attrs["num_grasps"] > 5
    assert "A00_0 is written without stable poses: its center of mass" in caplog.text


def test_grasps_of_an_object_that_is_not_there_are_refused(dataset, tmp_path, settings):
    export(settings, dataset, tmp_path, 2)
    parts = [tmp_path / f"part-2-{shard}.hdf5" for shard in range(2)]
    fuller = max(parts, key=lambda part: part.stat().st_size)
    with pytest.raises(UserError, match="is not among the written objects"):
        joined(settings, dataset, [part for part in parts if part != fuller], tmp_path / "out.hdf5")
