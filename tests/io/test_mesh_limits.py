"""Untrusted mesh files: bombs, files that name others, and random ones."""

import math
import re

import numpy as np
import pytest
from hostile_meshes import (
    BALL,
    BILLION,
    BOMBS,
    CORNERS,
    TRIANGLE,
    content,
    damaged,
    glb,
    many_attributes,
    plate,
    polygon_ply,
    scene,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from peak_memory import MEGABYTE, MEMORY, measured

from egad.errors import RejectedError
from egad.io import ENDINGS, read_mesh

SECONDS = 1  # that parsing may take here
SPARE = 30  # for all else, on a busy machine


def read(path):
    return f"a mesh of {len(read_mesh(path, 'm').faces)} faces"


@pytest.fixture(scope="module")
def cost(tmp_path_factory):
    warm = tmp_path_factory.mktemp("warm") / "ball.ply"
    BALL.export(warm)
    with measured(warm, SECONDS) as cost:
        yield cost


@pytest.mark.parametrize("name", BOMBS)
def test_hostile_files_are_refused_or_contained(cost, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(content(name))
    found = cost(read, path)
    assert re.search(BOMBS[name][1], found.outcome)
    size = path.stat().st_size
    assert found.own < 100 * MEGABYTE + 60 * min(size, 8 * MEGABYTE) + 12 * max(
        size - 8 * MEGABYTE, 0
    )
    assert found.limited <= MEMORY
    assert found.seconds < SECONDS + SPARE


def test_a_file_that_is_too_large_is_not_read(cost, tmp_path):
    with (tmp_path / "hole.stl").open("wb") as file:
        file.truncate(2 << 30)
    found = cost(read, tmp_path / "hole.stl")
    assert "RejectedError: 2,147,483,648 bytes" in found.outcome
    assert found.own < 10 * MEGABYTE


@pytest.mark.parametrize("more", ["", "f 1 2 3 1\n", "# a comment\n"])
def test_polygons_of_an_obj_file_are_read(tmp_path, more):
    (tmp_path / "a.obj").write_text(CORNERS + more + "f" + " 1 2 3" * 3_000 + "\n")
    assert len(read_mesh(tmp_path / "a.obj", "m").faces) in (8_998, 9_000)


def test_polygons_of_a_binary_ply_file_are_read(tmp_path):
    (tmp_path / "a.ply").write_bytes(polygon_ply(300))
    assert len(read_mesh(tmp_path / "a.ply", "m").faces) == 298


def test_attributes_of_a_glb_file_are_left_out(tmp_path):
    (tmp_path / "a.glb").write_bytes(many_attributes())
    assert len(read_mesh(tmp_path / "a.glb", "m").faces) == 33_333


OTHERS = np.eye(3, dtype="<f4").tobytes() + bytes(28)  # would make a triangle


@pytest.mark.parametrize("where", ["../secret", "/dev/zero", "file:///dev/zero", "/secret"])
def test_no_other_file_is_read(tmp_path, where):
    """With one that never ends, it would not end."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    (tmp_path / "secret").write_bytes(OTHERS)
    where = where.replace("/secret", f"{tmp_path}/secret") if where == "/secret" else where
    BALL.export(folder / "a.obj")
    text = (folder / "a.obj").read_text()
    (folder / "a.obj").write_text(f"mtllib {where}\nusemtl paint\nmap_Kd {where}\n{text}")
    BALL.export(folder / "b.ply", encoding="ascii")
    text = (folder / "b.ply").read_text()
    (folder / "b.ply").write_text(
        text.replace("\nelement", f"\ncomment TextureFile {where}\nelement", 1)
    )
    entity = f'<!DOCTYPE model [<!ENTITY a SYSTEM "{where}">]>'
    (folder / "c.3mf").write_bytes(plate(f'<object id="1" name="&a;">{TRIANGLE}</object>', entity))
    named = scene([{"mesh": 0}]) | {"buffers": [{"byteLength": 64, "uri": where}]}
    (folder / "d.glb").write_bytes(glb(named))
    assert read_mesh(folder / "a.obj", "m").volume == pytest.approx(BALL.volume)
    assert read_mesh(folder / "b.ply", "m").volume == pytest.approx(BALL.volume, rel=1e-6)
    for name in ("c.3mf", "d.glb"):
        with pytest.raises(RejectedError, match="not a readable"):
            read_mesh(folder / name, "m")


def test_many_materials_and_textures_make_one_mesh(tmp_path):
    """Apart they would take the vertices once for each."""
    lines = ["mtllib absent.mtl"]
    lines += [f"v {x} {y} {z}" for x, y, z in BALL.vertices.tolist()]
    lines += [f"vt {k / 1000} 0" for k in range(len(BALL.faces))]
    for number, face in enumerate((BALL.faces + 1).tolist()):
        lines += [f"usemtl m{number}", f"g part{number} # a comment", "# usemtl none"]
        lines.append("f " + " ".join(f"{corner}/{number + 1}/{corner}" for corner in face))
    (tmp_path / "ball.obj").write_text("\r\n".join(lines))
    mesh = read_mesh(tmp_path / "ball.obj", "m")
    assert mesh.is_volume
    assert np.array_equal(mesh.faces, BALL.faces)


def read_or_reject(folder, ending, data):
    """What any file must do: be a mesh with finite coordinates, or be refused."""
    path = folder / f"any{ending}"
    path.write_bytes(data)
    try:
        mesh = read_mesh(path, "m")
    except RejectedError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.area > 0
    assert mesh.faces.max() < len(mesh.vertices)


def fuzz(examples):
    return settings(
        max_examples=examples,
        derandomize=examples < 1000,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


@fuzz(150)
@given(damaged())
def test_damaged_files_are_meshes_or_refused(tmp_path, file):
    read_or_reject(tmp_path, *file)


@fuzz(150)
@given(st.sampled_from(ENDINGS), st.binary(max_size=400))
def test_random_bytes_are_meshes_or_refused(tmp_path, ending, data):
    read_or_reject(tmp_path, ending, data)


LEAF = st.none() | st.integers(-2, 9) | st.sampled_from([BILLION, math.pi, "VEC3", "data:", "x"])
KEYS = ["buffer", "byteLength", "count", "type", "mesh", "children", "POSITION", "indices", "nodes"]
JSON = st.recursive(
    LEAF, lambda some: st.lists(some, max_size=3) | st.dictionaries(st.sampled_from(KEYS), some)
)


@fuzz(60)
@given(st.dictionaries(st.sampled_from([*scene([]), "images", "scene", "extensions"]), JSON))
def test_any_structure_of_a_glb_file_is_a_mesh_or_refused(tmp_path, changes):
    read_or_reject(tmp_path, ".glb", glb(scene([{"mesh": 0}]) | changes))


@pytest.mark.slow
@fuzz(30_000)
@given(damaged())
def test_very_many_damaged_files_are_meshes_or_refused(tmp_path, file):
    read_or_reject(tmp_path, *file)
