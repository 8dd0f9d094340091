import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError, UserError
from egad.io import read_mesh, write_obj
from egad.io.units import METRES

BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.05)


@pytest.mark.parametrize("units", METRES)
def test_units_are_turned_into_metres(tmp_path, units):
    path = tmp_path / "ball.obj"
    write_obj(trimesh.Trimesh(BALL.vertices / METRES[units], BALL.faces, process=False), path)
    assert np.allclose(read_mesh(path, units).extents, BALL.extents)


def test_an_unknown_unit_and_a_missing_file_are_told(tmp_path):
    with pytest.raises(UserError, match="m, cm, mm, inch"):
        read_mesh(tmp_path / "any.obj", "furlong")
    with pytest.raises(RejectedError, match="no such file"):
        read_mesh(tmp_path / "any.obj", "m")


def test_obj_round_trip_is_exact_and_repeats(tmp_path):
    for name in ("a.obj", "b.obj"):
        write_obj(BALL, tmp_path / name)
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()
    mesh = read_mesh(tmp_path / "a.obj", "m")
    assert np.array_equal(mesh.vertices, BALL.vertices)
    assert np.array_equal(mesh.faces, BALL.faces)


def test_indented_lines_of_an_obj_file_count_too(tmp_path):
    path = tmp_path / "ball.obj"
    write_obj(BALL, path)
    indents, lines = ("", "  ", "\t"), path.read_text().splitlines()
    path.write_text("\n".join(indents[n % 3] + line for n, line in enumerate(lines)))
    mesh = read_mesh(path, "m")
    assert np.array_equal(mesh.vertices, BALL.vertices)
    assert np.array_equal(mesh.faces, BALL.faces)


BROKEN = {
    "half.ply": ("ply\nformat ascii 1.0\nelement vertex 3\n", "header does not end"),
    "binary.glb": ("\x00\x01\x02", "does not start with `glTF`"),
    "line.obj": ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no area"),
    "speck.obj": ("v 0 0 0\nv 1e-10 0 0\nv 0 1 0\nf 1 2 3\n", "no area"),  # merged to an edge
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_rejected_with_a_reason(tmp_path, name):
    content, reason = BROKEN[name]
    (tmp_path / name).write_text(content)
    with pytest.raises(RejectedError, match=reason):
        read_mesh(tmp_path / name, "m")


def test_want_of_memory_is_no_reason_to_reject_a_file(tmp_path, monkeypatch):
    BALL.export(tmp_path / "ball.obj")
    monkeypatch.setattr("egad.io.mesh.parse_obj", lambda _: np.ones(1 << 50))
    with pytest.raises(MemoryError):
        read_mesh(tmp_path / "ball.obj", "m")
