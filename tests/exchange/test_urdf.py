"""Objects as URDF; `tests/workflow/scripts/test_bundle.py` has mass and inertia in engines."""

from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from egad.exchange.object_files import DRAKE
from egad.exchange.objects import urdf, vgn


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
