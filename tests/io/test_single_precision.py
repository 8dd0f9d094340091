"""The same shape in every mesh format, to the bit."""

import numpy as np
import pytest

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


def test_millimetres_are_another_rounding(mesh, tmp_path):
    """A thousand is no power of two."""
    write_stl_mm(mesh, tmp_path / "a.stl")
    read = egad.read_mesh(tmp_path / "a.stl")
    exact = mesh.vertices[mesh.faces]
    assert np.abs(read.vertices[read.faces] - exact).max() <= 2**-24 * np.abs(exact).max()
