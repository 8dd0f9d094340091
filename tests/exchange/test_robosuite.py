"""Objects for robosuite; `docs/scripts/readers.py` lets robosuite itself read them."""

from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from egad.exchange.objects import robosuite


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
