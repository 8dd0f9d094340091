"""The bundle: files that agree, load in two engines, and describe objects that lie still."""

import hashlib
import json
import sys
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import mujoco
import numpy as np
import pandas as pd
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import egad
from egad.cli import main
from egad.errors import UserError
from egad.exchange import any_objects, evaluation_objects, model_in, rows_by_id, write_bundle
from egad.exchange.bundle import Item
from egad.geometry.checks import OPEN
from egad.geometry.mass import mass_properties
from egad.io import read_mesh, write_obj
from egad.sim import SimulationBundle
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE, EVAL49
from egad.tables.objects import REJECTED
from egad_workflow.settings import Settings, select

try:
    import pybullet
except ImportError:  # there is none for Python 3.12 and newer
    pybullet = None

SETTINGS = select(Settings(), SimulationBundle)
DENSITY = SETTINGS.material.density
ANGLE = 5.0  # degrees between a pose at rest and the listed one; the parts' faces are not exact
CLEARANCE = 0.0015  # m between listed and seen height: the parts are fatter, PyBullet adds 1 mm
DROP = 0.12  # m
# Rolling friction, m: it can hold objects on an edge, but without some, round ones never stop.
LITTLE, SOME = 1e-5, 1e-3


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


def drops_in_mujoco(bundle, name, turns, rolling):
    spec = mujoco.MjSpec.from_file(str(bundle / name / f"{name}.xml"))
    ground = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [1, 1, 0.1]}
    spec.worldbody.add_geom(**ground, friction=[0.5, 0.005, rolling], condim=6)
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


def drops_in_pybullet(bundle, name, turns, rolling):
    engine = pybullet.connect(pybullet.DIRECT)
    try:
        yield from _drops(bundle, name, turns, rolling)
    finally:
        pybullet.disconnect(engine)


def _drops(bundle, name, turns, rolling):
    pybullet.setGravity(0, 0, -9.81)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=1 / 240, numSolverIterations=150)
    table = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    pybullet.changeDynamics(
        table, -1, lateralFriction=1, rollingFriction=rolling, spinningFriction=rolling
    )
    body = pybullet.loadURDF(
        str(bundle / name / f"{name}.urdf"), flags=pybullet.URDF_USE_INERTIA_FROM_FILE
    )
    principal = Rotation.from_quat(pybullet.getDynamicsInfo(body, -1)[4])
    for turn in turns:
        start = (turn * principal).as_quat()
        pybullet.resetBasePositionAndOrientation(body, [0, 0, DROP], start)
        pybullet.resetBaseVelocity(body, [0, 0, 0], [0, 0, 0])
        still = 0
        for _ in range(240 * 10):
            pybullet.stepSimulation()
            speed, turning = pybullet.getBaseVelocity(body)
            resting = np.linalg.norm(speed) < 0.003 and np.linalg.norm(turning) < 0.05
            still = still + 1 if resting else 0
            if still == 240:
                break
        center, at = pybullet.getBasePositionAndOrientation(body)
        yield Rest(still == 240, Rotation.from_quat(at) * principal.inv(), np.array(center))


ENGINES = {"mujoco": drops_in_mujoco} | ({"pybullet": drops_in_pybullet} if pybullet else {})


def matches(bundle, name, engine, drops, rolling=LITTLE):
    """Whether each drop ended in a listed pose, and at rest; it must not fly off."""
    poses = listed(bundle, name)
    normals = np.array([pose["face_normal"] for pose in poses])
    turns = Rotation.random(drops, random_state=np.random.default_rng(5))
    for rest in ENGINES[engine](bundle, name, turns, rolling):
        assert np.abs(rest.center[:2]).max() < 0.5, "it flew off"
        down = rest.rotation.inv().apply([0, 0, -1])
        away = np.degrees(np.arccos(np.clip(normals @ down, -1, 1)))
        height = poses[int(away.argmin())]["height"]
        listed_pose = away.min() < ANGLE and abs(rest.center[2] - height) < CLEARANCE
        yield listed_pose, rest.still


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", MESHES)
def test_dropped_objects_come_to_rest_in_a_listed_pose(bundle, name, engine):
    assert np.all(list(matches(bundle, name, engine, drops=12)))


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


def test_a_box_has_six_poses_with_known_chances(bundle):
    poses = listed(bundle, "box")
    half = np.array([0.015, 0.02, 0.025])
    assert len(poses) == 6
    for pose in poses:
        axis = np.abs(pose["face_normal"]).argmax()
        (a, b), h = np.delete(half, axis), half[axis]
        share = np.arctan(a * b / (h * np.sqrt(a * a + b * b + h * h))) / np.pi
        assert pose["probability"] == pytest.approx(share, rel=1e-6)
        assert pose["height"] == pytest.approx(h)


@pytest.mark.parametrize("name", MESHES)
def test_poses_stand_on_the_table(bundle, meshes, name):
    mesh, center = read_mesh(meshes / f"{name}.obj", "m"), center_of(row_of(bundle, name))
    poses = listed(bundle, name)
    assert 0.98 < sum(pose["probability"] for pose in poses) <= 1 + 1e-9
    for pose in poses:
        placed = trimesh.transform_points([center, *mesh.vertices], pose["transform"])
        np.testing.assert_allclose(placed[0], [0, 0, pose["height"]], atol=1e-9)
        assert placed[1:, 2].min() == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", MESHES)
def test_descriptions_are_well_formed_and_name_files_that_are_there(bundle, name):
    folder = bundle / name
    robot = ElementTree.parse(folder / f"{name}.urdf").getroot()  # noqa: S314
    model = ElementTree.parse(folder / f"{name}.xml").getroot()  # noqa: S314
    files = [mesh.get("filename") for mesh in robot.iter("mesh")]
    assert files == [mesh.get("file") for mesh in model.iter("mesh")]
    made = {p.relative_to(folder).as_posix() for p in folder.rglob("*.obj")}
    assert set(files) == made
    assert len(files) == 1 + row_of(bundle, name)["parts"]


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


def test_an_object_whose_surface_lies_deep_in_a_part_is_marked(tmp_path, meshes, bundle):
    assert row_of(bundle, "ell")["buried"] == 0
    one = SETTINGS.bundle.model_copy(update={"max_parts": 1, "volume_error": 0.9})
    settings = SETTINGS.model_copy(update={"bundle": one})
    write_bundle(settings, any_objects([meshes / "ell.obj"]), "m", tmp_path / "out")
    row = row_of(tmp_path / "out", "ell")
    assert row["volume_error"] <= 0.9
    assert 0.1 < row["buried"] < 0.5
    assert not row["within"]


def test_the_evaluation_set_gives_labels_and_files(tmp_path):
    row = dict.fromkeys(EVAL49.names, 0) | {"label": "A0", "id": "x1", "object_label": "A00_0"}
    parquet.write(pd.DataFrame([row]), EVAL49, tmp_path / "eval.parquet")
    found = evaluation_objects(tmp_path / "eval.parquet", Path("folder"))
    assert found == [Item("A0", "x1", Path("folder/A00_0.obj"))]


def test_a_folder_that_holds_something_else_is_spared(tmp_path, meshes, monkeypatch):
    (tmp_path / "mine.txt").touch()
    monkeypatch.setattr(
        sys, "argv", ["egad", "bundle", str(meshes), "--units", "m", "--out", str(tmp_path)]
    )
    with pytest.raises(SystemExit, match="has other files, which would be lost"):
        main()


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


@pytest.mark.slow
def test_the_released_set_comes_to_rest(released_set, tmp_path):
    for label, mesh in released_set.items():
        write_obj(mesh, tmp_path / f"{label}.obj")
    out = tmp_path / "bundle"
    assert write_bundle(SETTINGS, any_objects(sorted(tmp_path.glob("*.obj"))), "m", out) == 0
    table = parquet.read(out / "bundle.parquet", BUNDLE).set_index("label")
    assert len(table) == 49
    assert table["within"].all()
    for engine in ENGINES:
        found = [drop for name in table.index for drop in matches(out, name, engine, 3, SOME)]
        posed, still = np.mean(found, axis=0)
        print(f"{engine}: {100 * posed:.1f} % in a listed pose, {100 * still:.1f} % at rest")
        assert posed > 0.93, engine  # round ones stop on the way for rolling friction
        assert still > 0.85, engine  # or roll and turn on the spot for longer than 10 s
