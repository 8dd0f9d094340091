"""Vertices that are not finite: passed over where no face uses them, otherwise refused."""

import time

import numpy as np
import pytest
from mesh_files import BOX_SIZE, BOX_VOLUME, CORNERS, POINTS, F, V, gltf, model, package, solid_xml

from egad.errors import RejectedError
from egad.io import read_mesh
from egad.io.text import with_plain_nan

SPELLINGS = ["nan", "NaN", "-nan", "nan(ind)", "-nan(ind)", "nan(snan)", "-NAN(IND)", "nan(0x8000)"]
SPELLINGS += ["1.#QNAN", "1.#QNAN0", "-1.#IND", "-1.#IND00", "1.#SNAN", "1.#INF", "-1.#INF00"]
SPELLINGS += ["1.#J", "-1.#J", "1.#R", "1.#QO", "-1.#IO", "1.#QNB", "1.#T"]  # with few digits
SPELLINGS += ["inf", "-inf", "Infinity", "1e999"]


def with_stray(word):
    """Rows of vertices as words, the second of which no face uses; and the faces."""
    rows = [[f"{x:g}" for x in row] for row in V]
    return [rows[0], [word, word, "0"], *rows[1:]], np.where(F > 0, F + 1, F)


def lines(rows):
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


def obj(rows, faces):
    return lines(["v", *row] for row in rows) + lines(["f", *(face + 1)] for face in faces)


def off(rows, faces):
    return f"OFF # of a test\n{len(rows)} {len(faces)} 0\n{lines(rows)}" + lines(
        [3, *face] for face in faces
    )


def off_on_any_lines(rows, faces):
    return off(rows, faces).replace("# of a test", "").replace(" ", "\n")


def ply(rows, faces, kind="float"):
    properties = "".join(f"property {kind} {axis}\n" for axis in "xyz")
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n{properties}element face "
        f"{len(faces)}\nproperty list uchar int vertex_indices\nend_header\n{lines(rows)}"
    ) + lines([3, *face] for face in faces)


def binary_ply(rows, faces):
    head, _, _ = ply(rows, faces, "double").partition("end_header\n")
    points = np.array([[float(word) for word in row] for row in rows], "<f8")
    corners = np.zeros(len(faces), [("n", "u1"), ("corners", "<i4", 3)])
    corners["n"], corners["corners"] = 3, faces
    head = head.replace("ascii", "binary_little_endian") + "end_header\n"
    return head.encode() + points.tobytes() + corners.tobytes()


def threemf(rows, faces):
    return package(model(solid_xml(1, np.array(rows, dtype=object), faces)))


WRITERS = {"obj": obj, "off": off, "ply": ply, "3mf": threemf}


def read(folder, ending, data):
    path = folder / f"a.{ending}"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_mesh(path, None if ending in ("3mf", "glb") else "mm")


def assert_is_box(mesh):
    assert len(mesh.vertices) == 8
    assert np.isfinite(mesh.vertices).all()
    assert 1000 * mesh.extents == pytest.approx(BOX_SIZE)
    assert 1e9 * mesh.volume == pytest.approx(BOX_VOLUME)


@pytest.mark.parametrize("word", SPELLINGS)
@pytest.mark.parametrize("ending", WRITERS)
def test_an_unused_vertex_that_is_not_finite_is_passed_over(tmp_path, ending, word):
    assert_is_box(read(tmp_path, ending, WRITERS[ending](*with_stray(word))))


@pytest.mark.parametrize("word", ["nan", "1.#QNAN", "-nan(ind)", "1.#INF"])
@pytest.mark.parametrize("ending", WRITERS)
def test_a_used_one_is_refused(tmp_path, ending, word):
    rows, faces = with_stray(word)
    with pytest.raises(RejectedError, match="not finite"):
        read(tmp_path, ending, WRITERS[ending](rows, np.vstack([faces, [0, 1, 2]])))


@pytest.mark.parametrize("word", ["nan", "-nan(ind)", "1.#QNAN"])
def test_also_in_off_that_is_not_divided_into_lines(tmp_path, word):
    assert_is_box(read(tmp_path, "off", off_on_any_lines(*with_stray(word))))


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_also_in_binary_files(tmp_path, value):
    assert_is_box(read(tmp_path, "ply", binary_ply(*with_stray(value))))
    stray = np.insert(POINTS, 1, np.float32(value), axis=0)
    mesh = read(
        tmp_path, "glb", gltf(stray, np.where(CORNERS > 0, CORNERS + 1, 0).astype("uint16"))
    )
    assert sorted(1000 * mesh.extents) == pytest.approx(sorted(BOX_SIZE))


@pytest.mark.parametrize("word", ["nan", "-nan(ind)", "1.#QNAN"])
def test_every_vertex_of_stl_is_used(tmp_path, word):
    corners = "".join(f"vertex {x}\n" for x in ("0 0 0", f"{word} 0 0", "0 1 0"))
    text = f"solid a\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid a\n"
    with pytest.raises(RejectedError, match="not finite"):
        read(tmp_path, "stl", text)


def test_what_only_looks_like_such_a_number_stays():
    text = b"v 1.#Just a comment\n# nan (of) f(x) nan(a b) 1.#5\n"
    assert with_plain_nan(text) == text


@pytest.mark.parametrize(
    "text", [b"# (a) nan(\n" + b"v 0.12 0.23 0.34\n" * 2_000_000, b"nan(" * 10**6]
)
def test_a_bracket_costs_no_time(text):
    before = time.process_time()
    assert with_plain_nan(text) == text
    assert time.process_time() - before < 0.5  # seconds
