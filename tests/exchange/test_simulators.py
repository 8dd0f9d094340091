"""Objects of a simulation bundle, written and read again."""

import mujoco
import numpy as np
import pytest
import trimesh

from egad.errors import UserError
from egad.exchange import read_simulation_object, write_simulation_object
from egad.geometry import Bundle
from egad.sim import make_simulation_object


def row_of(made):
    inertia, com = made.physics.inertia, made.physics.com
    places = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return {
        "label": "ell",
        "parts": len(made.parts),
        "volume": made.physics.volume,
        "mass": made.physics.mass,
        **{f"com_{axis}": value for axis, value in zip("xyz", com, strict=True)},
        **{f"inertia_{axes}": inertia[place] for axes, place in places.items()},
        "volume_error": made.volume_error,
        "deviation": made.deviation,
        "buried": made.buried,
        "deviation_bound": made.deviation_bound,
        "within": made.within,
    }


@pytest.fixture
def bundle(made, tmp_path):
    write_simulation_object(tmp_path / "ell", "ell", made, 0.4)
    return tmp_path


def test_an_object_read_and_written_again_is_the_same(bundle, made, tmp_path):
    found = read_simulation_object(bundle, row_of(made))
    np.testing.assert_array_equal(found.physics.inertia, made.physics.inertia)
    assert found.physics.area == pytest.approx(made.physics.area)
    write_simulation_object(tmp_path / "again", "ell", found, 0.4)
    for path in (bundle / "ell").rglob("*.*"):
        again = tmp_path / "again" / path.relative_to(bundle / "ell")
        assert again.read_bytes() == path.read_bytes(), path


def test_damaged_files_are_named(bundle, made):
    (bundle / "ell/visual.obj").write_text("no mesh")
    with pytest.raises(UserError, match=r"ell: no faces; make the bundle again"):
        read_simulation_object(bundle, row_of(made))
    (bundle / "ell/parts/part-001.obj").unlink()
    with pytest.raises(UserError, match=r"1 convex parts, but .*bundle.parquet lists 2"):
        read_simulation_object(bundle, row_of(made))


BEADS = {
    "ball": lambda: trimesh.creation.icosphere(3, 0.5),
    "bead": lambda: trimesh.creation.annulus(0.2, 0.5, 1.0),
    "wire": lambda: trimesh.creation.box((1, 0.05, 0.05)),
}


@pytest.mark.parametrize("size", [0.0001, 0.0005, 0.001, 0.02])
@pytest.mark.parametrize("name", BEADS)
def test_objects_of_any_size_load_in_mujoco(name, size, tmp_path):
    made = make_simulation_object(BEADS[name]().apply_scale(size), 400.0, Bundle())
    write_simulation_object(tmp_path / name, name, made, 0.4)
    mujoco.MjModel.from_xml_path(str(tmp_path / name / f"{name}.urdf"))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / name / f"{name}.xml"))
    assert model.body_mass[1] == pytest.approx(made.physics.mass, rel=1e-9)
    moments = np.sort(np.linalg.eigvalsh(made.physics.inertia))
    expected = np.maximum(moments, 2e-14)
    np.testing.assert_allclose(np.sort(model.body_inertia[1]), expected, rtol=1e-6)
