"""Objects as SDFormat, after its specification; `docs/scripts/readers.py` lets Drake read them."""

from xml.etree import ElementTree

import numpy as np
import pytest

from egad.exchange.objects import sdf


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
