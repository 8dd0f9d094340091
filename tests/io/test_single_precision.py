"""The same shape in every mesh format, to the bit."""

import numpy as np
import pytest
import trimesh

import egad
from egad.io import write_glb, write_obj, write_stl_mm

FORMATS = ("obj", "stl", "ply", "glb")


def in_all_formats(mesh, folder):
    """A mesh in files of each format, in metres, read again."""
    write_obj(mesh, folder / "a.obj")
    write_glb(mesh, folder / "a.glb")
    mesh.export(folder / "a.ply")
    mesh.export(folder / "a.stl")
    return {each: egad.read_mesh(folder / f"a.{each}", units="m") for each in FORMATS}


@pytest.fixture(scope="module", params=["evolved", "scaled"])
def mesh(request):
    found = egad.load("released")["M14_3"].mesh
    return found if request.param == "evolved" else egad.rescale(found, "panda")[0]


def test_every_format_gives_the_same_triangles(mesh, tmp_path):
    for read in in_all_formats(mesh, tmp_path).values():
        assert read.vertices[read.faces].tobytes() == mesh.vertices[mesh.faces].tobytes()
        assert len(read.vertices) == len(mesh.vertices)


@pytest.mark.parametrize("name", ["obj", "ply", "glb"])
def test_formats_with_shared_vertices_keep_them(mesh, tmp_path, name):
    read = in_all_formats(mesh, tmp_path)[name]
    assert np.array_equal(read.vertices, mesh.vertices)
    assert np.array_equal(read.faces, mesh.faces)


def test_other_programs_read_the_same_numbers(mesh, tmp_path):
    write_obj(mesh, tmp_path / "a.obj")
    read = trimesh.load_mesh(tmp_path / "a.obj", process=False, maintain_order=True)
    assert np.array_equal(read.vertices, mesh.vertices)


def test_millimetres_are_another_rounding(mesh, tmp_path):
    """A thousand is no power of two."""
    write_stl_mm(mesh, tmp_path / "a.stl")
    read = egad.read_mesh(tmp_path / "a.stl")
    exact = mesh.vertices[mesh.faces]
    assert np.abs(read.vertices[read.faces] - exact).max() <= 2**-24 * np.abs(exact).max()


def test_a_mesh_in_double_precision_keeps_all_digits(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.0517)
    write_obj(ball, tmp_path / "a.obj")
    assert np.array_equal(egad.read_mesh(tmp_path / "a.obj", units="m").vertices, ball.vertices)


def test_exported_objects_are_those_of_the_dataset(tmp_path):
    chosen = egad.load("evaluation-set").select(["A0"])
    for name in ("obj", "glb"):
        egad.export(chosen, name, "panda", tmp_path / name)
    scaled, _ = egad.rescale(chosen["A0"].mesh, "panda")
    for name in ("obj", "glb"):
        read = egad.read_mesh(tmp_path / name / f"A0.{name}", units="m")
        assert np.array_equal(read.vertices, scaled.vertices)
