"""The bundle: files that agree, load in two engines, and describe objects that lie still."""

import hashlib
import json
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import egad
from egad.errors import UserError
from egad.exchange import any_objects, model_in, rows_by_id, write_bundle
from egad.exchange.bundle import Item
from egad.geometry.checks import OPEN
from egad.geometry.mass import mass_properties
from egad.io import read_mesh, write_obj
from egad.sim import SimulationBundle
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE
from egad.tables.objects import REJECTED
from egad_workflow.settings import Settings, select

try:
    import pybullet
except ImportError:  # there is none for Python 3.12 and newer
    pybullet = None

SETTINGS = select(Settings(), SimulationBundle)
DENSITY = SETTINGS.material.density
ANGLE = 5.0  # degrees between a pose at rest and the listed one; the parts' faces are not exact
CLEARANCE = 0.0015  # m between listed and seen height: the parts are fatter
DROP = 0.12  # m
ROLLING = 1e-5  # m, friction: it can hold objects on an edge, but without some they never stop


def slab(size, at):
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(at))


def cup():
    outer = trimesh.creation.cylinder(0.025, 0.06, sections=12)
    inner = trimesh.creation.cylinder(0.020, 0.06, sections=12).apply_translation([0, 0, 0.005])
    return trimesh.boolean.difference([outer, inner], engine="manifold")


def ell():
    arms = [slab((0.06, 0.02, 0.02), (0.05, 0, 0)), slab((0.02, 0.02, 0.06), (0.03, 0, 0.02))]
    return trimesh.boolean.union(arms, engine="manifold")


def wedge():
    low = [[x, y, 0] for x in (0, 0.05) for y in (0, 0.03)]
    return trimesh.Trimesh([*low, [0.01, 0.005, 0.03], [0.01, 0.025, 0.03]]).convex_hull


MESHES = {
    "box": lambda: slab((0.03, 0.04, 0.05), (0.1, 0.2, 0.3)),
    "cup": cup,
    "ell": ell,
    "wedge": wedge,
}


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("meshes")
    for name, mesh in MESHES.items():
        write_obj(mesh(), folder / f"{name}.obj")
    return folder


@pytest.fixture(scope="module")
def bundle(meshes, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "bundle"
    assert write_bundle(SETTINGS, any_objects(sorted(meshes.glob("*.obj"))), "m", out) == 0
    return out


class Rest(NamedTuple):
    still: bool
    rotation: Rotation
    center: np.ndarray


def listed(bundle, name):
    return json.loads((bundle / name / "poses.json").read_text())


def row_of(bundle, name):
    return parquet.read(bundle / "bundle.parquet", BUNDLE).set_index("label").loc[name]


def center_of(row):
    return row[["com_x", "com_y", "com_z"]].to_numpy(float)


def tensor_of(row):
    xx, yy, zz, xy, xz, yz = (
        row[f"inertia_{part}"] for part in ("xx", "yy", "zz", "xy", "xz", "yz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def drops(bundle, name, turns):
    """Drop an object with each rotation onto a plane in MuJoCo."""
    spec = mujoco.MjSpec.from_file(str(bundle / name / f"{name}.xml"))
    ground = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [1, 1, 0.1]}
    spec.worldbody.add_geom(**ground, friction=[0.5, 0.005, ROLLING], condim=6)
    model = spec.compile()
    data = mujoco.MjData(model)
    center = center_of(row_of(bundle, name))
    for turn in turns:
        mujoco.mj_resetData(model, data)
        x, y, z, w = turn.as_quat()
        data.qpos[:] = [*([0, 0, DROP] - turn.apply(center)), w, x, y, z]
        still = 0
        for _ in range(10000):
            mujoco.mj_step(model, data)
            resting = np.abs(data.qvel[:3]).max() < 0.003 and np.abs(data.qvel[3:]).max() < 0.05
            still = still + 1 if resting else 0
            if still == 500:
                break
        w, x, y, z = data.qpos[3:]
        yield Rest(still == 500, Rotation.from_quat([x, y, z, w]), data.xipos[1].copy())


@pytest.mark.parametrize("name", MESHES)
def test_dropped_objects_come_to_rest_in_a_listed_pose(bundle, name):
    poses = listed(bundle, name)
    normals = np.array([pose["face_normal"] for pose in poses])
    turns = Rotation.random(12, random_state=np.random.default_rng(5))
    for rest in drops(bundle, name, turns):
        assert np.abs(rest.center[:2]).max() < 0.5, "it flew off"
        down = rest.rotation.inv().apply([0, 0, -1])
        away = np.degrees(np.arccos(np.clip(normals @ down, -1, 1)))
        height = poses[int(away.argmin())]["height"]
        assert away.min() < ANGLE
        assert rest.center[2] == pytest.approx(height, abs=CLEARANCE)
        assert rest.still


@pytest.mark.parametrize("name", MESHES)
def test_mujoco_gets_mass_and_inertia_of_the_mesh(bundle, meshes, name):
    expected = mass_properties(read_mesh(meshes / f"{name}.obj", "m"), DENSITY)
    row = row_of(bundle, name)
    assert row["mass"] == pytest.approx(expected.mass, rel=1e-6)
    np.testing.assert_allclose(center_of(row), expected.com, atol=1e-9)
    np.testing.assert_allclose(tensor_of(row), expected.inertia, rtol=1e-6, atol=1e-13)
    principal = np.linalg.eigvalsh(expected.inertia)
    model = mujoco.MjModel.from_xml_path(str(bundle / name / f"{name}.xml"))
    assert model.body_mass[1] == pytest.approx(expected.mass, rel=1e-6)
    np.testing.assert_allclose(np.sort(model.body_inertia[1]), principal, rtol=1e-6)
    np.testing.assert_allclose(model.body_ipos[1], expected.com, atol=1e-9)


@pytest.mark.skipif(pybullet is None, reason="not installed")
@pytest.mark.parametrize("name", MESHES)
def test_pybullet_gets_mass_and_inertia_of_the_mesh(bundle, meshes, name):
    expected = mass_properties(read_mesh(meshes / f"{name}.obj", "m"), DENSITY)
    principal = np.linalg.eigvalsh(expected.inertia)
    engine = pybullet.connect(pybullet.DIRECT)
    path, flags = str(bundle / name / f"{name}.urdf"), pybullet.URDF_USE_INERTIA_FROM_FILE
    info = pybullet.getDynamicsInfo(pybullet.loadURDF(path, flags=flags), -1)
    pybullet.disconnect(engine)
    assert info[0] == pytest.approx(expected.mass, rel=1e-6)
    np.testing.assert_allclose(np.sort(info[2]), principal, rtol=1e-5)
    assert info[1] == SETTINGS.bundle.friction


@pytest.mark.parametrize("name", MESHES)
def test_poses_stand_on_the_table(bundle, meshes, name):
    mesh, center = read_mesh(meshes / f"{name}.obj", "m"), center_of(row_of(bundle, name))
    poses = listed(bundle, name)
    assert 0.98 < sum(pose["probability"] for pose in poses) <= 1 + 1e-9
    for pose in poses:
        placed = trimesh.transform_points([center, *mesh.vertices], pose["transform"])
        np.testing.assert_allclose(placed[0], [0, 0, pose["height"]], atol=1e-9)
        assert placed[1:, 2].min() == pytest.approx(0, abs=1e-9)


def test_the_table_says_how_close_the_parts_are(bundle):
    table = parquet.read(bundle / "bundle.parquet", BUNDLE).set_index("label")
    assert table["within"].all()
    assert (table["volume_error"].abs() <= SETTINGS.bundle.volume_error).all()
    assert table.loc["ell", "parts"] == 2
    assert table.loc[["box", "ell", "wedge"], "deviation"].max() < 1e-4
    assert 0 < table.loc["cup", "deviation"] < 0.005
    assert "| cup |" in (bundle / "README.md").read_text()


def test_the_sums_are_those_of_all_files(bundle):
    lines = (bundle / "SHA256SUMS").read_text().splitlines()
    sums = {name: value for value, name in (line.split("  ") for line in lines)}
    files = {p.relative_to(bundle).as_posix(): p for p in bundle.rglob("*") if p.is_file()}
    files.pop("SHA256SUMS")
    assert sums == {n: hashlib.sha256(p.read_bytes()).hexdigest() for n, p in files.items()}


def test_more_processes_make_the_same_bytes(bundle, meshes, tmp_path):
    write_bundle(SETTINGS, any_objects(sorted(meshes.glob("*.obj"))), "m", tmp_path / "again", 2)
    assert (tmp_path / "again/SHA256SUMS").read_text() == (bundle / "SHA256SUMS").read_text()


def test_what_cannot_be_used_is_named_and_the_rest_is_made(tmp_path, meshes, bundle):
    cube = trimesh.creation.box((0.03, 0.03, 0.03))
    bad = tmp_path / "bad"
    bad.mkdir()
    write_obj(trimesh.Trimesh(cube.vertices, cube.faces[1:], process=False), bad / "open.obj")
    write_obj(
        trimesh.Trimesh(cube.vertices * [1, 1, 0], cube.faces, process=False), bad / "flat.obj"
    )
    (bad / "text.obj").write_text("no mesh\n")
    names = ("open", "flat", "text", "missing")
    items = [Item(name, f"id-{name}", bad / f"{name}.obj") for name in names]
    items.append(Item("box", "id-box", meshes / "box.obj"))
    assert write_bundle(SETTINGS, items, "m", tmp_path / "out") == 4
    rejected = parquet.read(tmp_path / "out/rejected.parquet", REJECTED)
    assert rejected["id"].tolist() == [f"id-{name}" for name in names]
    assert rejected["reason"].iloc[3] == "missing: no such file"
    assert rejected["reason"].iloc[:2].tolist() == [f"open: {OPEN}", "flat: no volume"]
    assert f"id-open: open: {OPEN}" in (tmp_path / "out/README.md").read_text()
    assert (tmp_path / "out/box/box.urdf").read_bytes() == (bundle / "box/box.urdf").read_bytes()


def test_an_object_beyond_the_bound_is_marked(tmp_path, meshes):
    coarse = SETTINGS.bundle.model_copy(update={"max_parts": 2})
    settings = SETTINGS.model_copy(update={"bundle": coarse})
    with pytest.warns(egad.PartsWarning, match="convex parts of cup exceed the requested bounds"):
        write_bundle(settings, any_objects([meshes / "cup.obj"]), "m", tmp_path / "out")
    row = row_of(tmp_path / "out", "cup")
    assert row["deviation_bound"] > coarse.deviation
    with pytest.warns(egad.PartsWarning, match="convex parts of cup exceed the requested bounds"):
        model_in(tmp_path / "out", rows_by_id(tmp_path / "out")["cup"])
    assert not row["within"]
    assert row["parts"] <= 2
    assert f"{row['volume_error']:.1%} !" in (tmp_path / "out/README.md").read_text()


def test_coacd_is_asked_for_only_if_it_is_there(tmp_path, meshes, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    other = SETTINGS.bundle.model_copy(update={"method": "coacd"})
    settings = SETTINGS.model_copy(update={"bundle": other})
    with pytest.raises(UserError, match=r"pip install 'egad\[coacd\]'"):
        write_bundle(settings, any_objects([meshes / "box.obj"]), "m", tmp_path / "out")


def test_coacd_makes_parts_in_a_process_of_its_own(tmp_path, meshes):
    pytest.importorskip("coacd")
    other = SETTINGS.bundle.model_copy(update={"method": "coacd"})
    settings = SETTINGS.model_copy(update={"bundle": other})
    write_bundle(settings, any_objects([meshes / "ell.obj"]), "m", tmp_path / "out")
    row = row_of(tmp_path / "out", "ell")
    assert (row["method"], row["parts"]) == ("coacd", 2)
    assert abs(row["volume_error"]) < 0.02
