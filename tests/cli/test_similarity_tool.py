import dataclasses

import numpy as np
import pytest
import trimesh

from egad.cli.similarity import graph_of, similarity_of_files
from egad.measures.reeb import Similarity
from egad.measures.reeb import graph as reeb
from egad.measures.reeb.similarity import similarity

SETTINGS = Similarity(vertices=600, base_count=15)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shapes")
    torus = trimesh.creation.torus(0.04, 0.01, major_sections=24, minor_sections=12)
    pieces = [torus, trimesh.creation.box([0.001] * 3).apply_translation([1, 0, 0])]
    meshes = {
        "torus": torus,
        "box": trimesh.creation.box([0.02, 0.03, 0.08]),
        "pieces": trimesh.util.concatenate(pieces),
        "flat": trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    }
    for name, mesh in meshes.items():
        mesh.export(folder / f"{name}.off")
    return {name: folder / f"{name}.off" for name in (*meshes, "absent")}


def test_the_matrix_is_square_and_in_the_order_given(files):
    matrix, reasons = similarity_of_files(SETTINGS, files, "m", 1)
    assert list(matrix.index) == list(matrix.columns) == list(files)
    assert list(reasons) == ["flat", "absent"]
    assert reasons["absent"] == "no such file"
    known = matrix.drop(index=list(reasons), columns=list(reasons))
    assert matrix[list(reasons)].isna().all(axis=None)
    assert np.array_equal(known, known.T)
    assert np.array_equal(np.diag(known), np.ones(3))


def test_values_are_those_of_the_library(files):
    chosen = {name: files[name] for name in ("torus", "box")}
    matrix, _ = similarity_of_files(SETTINGS, chosen, "m", 1)
    graphs = [reeb.extract(trimesh.load(files[name]), SETTINGS) for name in ("torus", "box")]
    assert matrix.loc["torus", "box"] == pytest.approx(similarity(*graphs, 0.5), abs=1e-9)


@pytest.mark.parametrize(("bases", "least"), [("even", 0.98), ("scan", 0.8)])
def test_a_mesh_in_pieces_is_repaired_first(files, bases, least):
    """Repair orders the vertices anew, which counts for `scan`."""
    settings = SETTINGS.model_copy(update={"bases": bases})
    chosen = {name: files[name] for name in ("torus", "pieces")}
    matrix, _ = similarity_of_files(settings, chosen, "m", 1)
    assert matrix.loc["torus", "pieces"] > least


def test_only_even_bases_are_taken_after_repair():
    box = trimesh.creation.box([0.02, 0.03, 0.08]).subdivide()
    holed = trimesh.Trimesh(box.vertices, box.faces[1:], process=False)
    scan = SETTINGS.model_copy(update={"bases": "scan"})
    even, raw = (graph_of(holed, settings, "holed") for settings in (SETTINGS, scan))
    assert similarity(even, reeb.extract(box, SETTINGS), 0.5) > 0.98
    assert fields(raw) == fields(reeb.extract(holed, scan))


def fields(graph):
    return [getattr(graph, field.name).tolist() for field in dataclasses.fields(graph)]


def test_workers_leave_no_trace(files):
    one, _ = similarity_of_files(SETTINGS, files, "m", 1)
    two, _ = similarity_of_files(SETTINGS, files, "m", 2)
    assert one.equals(two)
