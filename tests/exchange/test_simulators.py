"""Objects of a simulation bundle, written and read again."""

import numpy as np
import pytest

from egad.errors import UserError
from egad.exchange import read_simulation_object, write_simulation_object


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
    }


@pytest.fixture
def bundle(made, tmp_path):
    write_simulation_object(tmp_path / "ell", "ell", made, 0.4)
    return tmp_path


def test_an_object_read_and_written_again_is_the_same(bundle, made, tmp_path):
    found = read_simulation_object(bundle, row_of(made))
    np.testing.assert_array_equal(found.physics.inertia, made.physics.inertia)
    assert found.physics.area == pytest.approx(made.physics.area)
    for pose, other in zip(found.poses, made.poses, strict=True):
        assert set(other.face) <= set(pose.face)
        np.testing.assert_allclose(pose.matrix, other.matrix, atol=1e-12)
    write_simulation_object(tmp_path / "again", "ell", found, 0.4)
    for path in (bundle / "ell").rglob("*.*"):
        if path.name != "poses.json":  # the last digit of an angle in degrees may differ
            again = tmp_path / "again" / path.relative_to(bundle / "ell")
            assert again.read_bytes() == path.read_bytes(), path


def test_damaged_files_are_named(bundle, made):
    (bundle / "ell/poses.json").write_text("[{}]")
    with pytest.raises(UserError, match=r"poses.json: missing or damaged; make the bundle again"):
        read_simulation_object(bundle, row_of(made))
    (bundle / "ell/visual.obj").write_text("no mesh")
    with pytest.raises(UserError, match=r"ell: no faces; make the bundle again"):
        read_simulation_object(bundle, row_of(made))
    (bundle / "ell/parts/part-001.obj").unlink()
    with pytest.raises(UserError, match=r"1 convex parts, but .*bundle.parquet lists 2"):
        read_simulation_object(bundle, row_of(made))
