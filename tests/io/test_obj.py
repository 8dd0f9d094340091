import numpy as np
import pytest
import trimesh

from egad.io.obj import obj_text, parse_plain_obj

VERTICES = np.array([[0, 0, 0], [1e-17, -0.1, 1 / 3], [2.5e300, 4, -7e-5]])
FACES = np.array([[0, 1, 2], [2, 1, 0]])


def test_round_trip_is_exact():
    vertices, faces = parse_plain_obj(obj_text(VERTICES, FACES).encode())
    assert vertices.tobytes() == VERTICES.tobytes()
    assert np.array_equal(faces, FACES)


def test_numbers_are_those_of_repr():
    rng = np.random.default_rng(0)
    anything = rng.integers(0, 2**63, size=3000).view(np.float64)
    usual = rng.normal(size=3000) * 10.0 ** rng.uniform(-8, 8, size=3000)
    rounded = np.round(usual, 3)
    edges = [0.0, -0.0, 1e-4, 9.999999999999999e-5, -1e-5, 999999.5, 1e6, 1e15, 1e16, 1e17, 5e-324]
    values = np.concatenate([anything[np.isfinite(anything)], usual, rounded, edges])
    values = values[: len(values) // 3 * 3]
    lines = obj_text(values.reshape(-1, 3), FACES).splitlines()
    words = " ".join(lines).replace("v ", "").split(" f ")[0].split(" ")
    assert words == [repr(value) for value in values.tolist()]


def test_the_same_arrays_as_trimesh_reads(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.0517)
    path = tmp_path / "ball.obj"
    path.write_text(obj_text(ball.vertices, ball.faces))
    slow = trimesh.load_mesh(path, process=False, maintain_order=True)
    vertices, faces = parse_plain_obj(path.read_bytes())
    assert vertices.tobytes() == np.asarray(slow.vertices).tobytes()
    assert np.array_equal(faces, slow.faces)


LINES = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"]


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (0, "# a comment"),
        (1, "v 1 0"),
        (1, "v 1 0 0 1"),
        (1, " v 1 0 0"),
        (1, "vn 1 0 0"),
        (1, "v nan 0 0"),
        (1, "v 1-2 0 0"),
        (3, "f 1 2 3 1"),
        (3, "f 1/1 2/2 3/3"),
        (3, "l 1 2 3"),
    ],
)
def test_anything_else_is_left_to_others(place, line):
    assert parse_plain_obj("\n".join([*LINES, ""]).encode()) is not None
    changed = [*LINES[:place], line, *LINES[place + 1 :], ""]
    assert parse_plain_obj("\n".join(changed).encode()) is None


def test_uneven_lines_are_not_plain_though_their_numbers_add_up():
    text = "v 0 0\nv 1 0 0 0\nv 0 1 0\nf 1 2 3\n"
    assert parse_plain_obj(text.encode()) is None


def test_a_file_that_is_cut_or_has_no_faces_is_not_plain():
    whole = "\n".join(LINES)
    for text in ("", whole, "\n".join(LINES[:3]) + "\n", "f 1 2 3\n"):
        assert parse_plain_obj(text.encode()) is None
