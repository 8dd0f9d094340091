"""Objects as URDF, SDFormat and for robosuite; programs read them in `studies/exports`."""

from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
import trimesh

from egad.exchange.object_files import DRAKE
from egad.exchange.objects import robosuite, sdf, urdf, vgn


def test_each_part_says_its_friction_and_that_it_is_convex(tmp_path, made):
    urdf.write(tmp_path, "ell", made, 0.4)
    robot = ElementTree.parse(tmp_path / "ell/ell.urdf").getroot()  # noqa: S314
    parts = robot.findall("link/collision")
    assert len(parts) == len(made.parts)
    for part in parts:
        assert part.find(f"geometry/mesh/{{{DRAKE}}}declare_convex") is not None
        properties = part.find(f"{{{DRAKE}}}proximity_properties")
        assert {float(each.get("value")) for each in properties} == {0.4}
        assert len(properties) == 2


def test_vgn_gets_the_files_of_all_objects_in_one_folder(tmp_path, made, monkeypatch):
    pybullet = pytest.importorskip("pybullet")
    for name in ("a", "b"):
        vgn.write(tmp_path, name, made, 0.4)
    monkeypatch.chdir(tmp_path.parent)
    engine = pybullet.connect(pybullet.DIRECT)
    try:
        for file in sorted(tmp_path.glob("*.urdf")):
            body = pybullet.loadURDF(str(file), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
            assert len(pybullet.getCollisionShapeData(body, -1)) == len(made.parts)
            assert pybullet.getDynamicsInfo(body, -1)[1] == 0.4
    finally:
        pybullet.disconnect(engine)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "a.urdf", "b", "b.urdf"]


def test_mesh_files_are_those_of_the_object(tmp_path, made):
    urdf.write(tmp_path, "ell", made, 0.4)
    visual = trimesh.load_mesh(tmp_path / "ell/visual.obj")
    assert visual.volume == pytest.approx(made.mesh.volume)
    robot = ElementTree.parse(tmp_path / "ell/ell.urdf").getroot()  # noqa: S314
    meshes = robot.findall("link/collision/geometry/mesh")
    for mesh, part in zip(meshes, made.parts, strict=True):
        found = trimesh.load_mesh(tmp_path / "ell" / mesh.get("filename"))
        found.apply_scale(np.array(mesh.get("scale").split(), float))
        np.testing.assert_allclose(found.bounds, part.bounds)


@pytest.fixture(scope="module")
def folder(made, tmp_path_factory):
    out = tmp_path_factory.mktemp("sdf")
    sdf.write(out, "ell", made, 0.4)
    return out / "ell"


@pytest.fixture(scope="module")
def model(folder):
    root = ElementTree.parse(folder / "model.sdf").getroot()  # noqa: S314
    return root.find("model")


def test_the_description_names_the_model_file(folder, model):
    described = ElementTree.parse(folder / "model.config").getroot()  # noqa: S314
    assert (folder / described.find("sdf").text).is_file()
    assert described.find("name").text == model.get("name") == "ell"


def test_mass_properties_are_those_of_the_solid(model, made):
    inertial = model.find("link/inertial")
    pose = np.array(inertial.find("pose").text.split(), float)
    np.testing.assert_array_equal(pose, [*made.physics.com, 0, 0, 0])
    assert float(inertial.find("mass").text) == made.physics.mass
    xx, yy, zz, xy, xz, yz = (
        float(inertial.find(f"inertia/i{axes}").text)
        for axes in ["xx", "yy", "zz", "xy", "xz", "yz"]
    )
    tensor = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    np.testing.assert_array_equal(tensor, made.physics.inertia)


def test_every_part_is_a_convex_collider_with_friction(folder, model, made):
    parts = model.findall("link/collision")
    assert len({part.get("name") for part in parts}) == len(made.parts)
    for part in parts:
        mesh = part.find("geometry/mesh")
        assert mesh.get("optimization") == "convex_hull"
        assert (folder / mesh.find("uri").text).is_file()
        assert [float(each.text) for each in part.find("surface/friction/ode")] == [0.4, 0.4]


@pytest.fixture(scope="module")
def file(made, tmp_path_factory):
    folder = tmp_path_factory.mktemp("robosuite")
    robosuite.write(folder, "ell", made, 0.4)
    return folder / "ell/ell.xml"


def test_the_body_is_where_robosuite_looks_for_it(file):
    root = ElementTree.parse(file).getroot()  # noqa: S314
    assert root.find("./worldbody/body").get("name") is None
    assert len(root.findall("./worldbody/body/body[@name='object']")) == 1
    assert list(root.iter("freejoint")) == list(root.iter("joint")) == []


def test_mujoco_compiles_it_with_exact_mass_and_groups(file, made):
    model = mujoco.MjModel.from_xml_path(str(file))
    body = model.body("object").id
    assert model.body_mass[body] == pytest.approx(made.physics.mass)
    np.testing.assert_allclose(model.body_ipos[body], made.physics.com)
    collides = model.geom_contype > 0
    assert collides.sum() == len(made.parts)
    assert set(model.geom_group[collides]) == {0}
    assert set(model.geom_group[~collides]) == {1}
    assert set(model.geom_friction[collides, 0]) == {0.4}


def test_sites_bound_the_object(file, made):
    model = mujoco.MjModel.from_xml_path(str(file))
    low, high = made.mesh.bounds[:, 2]
    np.testing.assert_allclose(model.site("bottom_site").pos, [0, 0, low])
    np.testing.assert_allclose(model.site("top_site").pos, [0, 0, high])
    radius = model.site("horizontal_radius_site").pos[0]
    assert radius == np.hypot(*made.mesh.vertices[:, :2].T).max()
