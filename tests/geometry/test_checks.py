"""Bad meshes at the functions that users call: a typed error with a sentence, never a crash."""

import contextlib
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

import egad
from egad.errors import RejectedError, UserError
from egad.geometry.checks import UnitsWarning, check_mesh, check_solid, check_units
from egad.geometry.convex_parts import decompose
from egad.geometry.mass import mass_properties
from egad.geometry.repair import repair, repair_for_files
from egad.geometry.scaling import box_sides, rescale
from egad.geometry.stable_poses import resting_poses
from egad.grasps.parameters import LabelParameters
from egad.grasps.sampling import Labeller
from egad.grasps.suction import sample_suction
from egad.measures.complexity import complexity
from egad.measures.measure import measure_repeatably
from egad.measures.parameters import MeasureParameters
from egad.measures.reeb import graph as reeb
from egad_workflow.settings import Settings, select

SETTINGS = Settings()
LABELS = select(SETTINGS, LabelParameters)
BOX = trimesh.creation.box((0.02, 0.03, 0.05))
FLATTEN = np.eye(3) - np.outer([1, 2, 2], [1, 2, 2]) / 9  # along an oblique direction


def raw(vertices, faces):
    return trimesh.Trimesh(vertices, faces, process=False)


def with_vertex(value):
    vertices = BOX.vertices.copy()
    vertices[3] = value
    return raw(vertices, BOX.faces)


def with_corner(index):
    faces = BOX.faces.copy()
    faces[0, 0] = index
    return raw(BOX.vertices, faces)


FUNCTIONS = {
    "repair": repair,
    "thicken": lambda mesh: repair(mesh, "thicken"),
    "body": repair_for_files,
    "mass_properties": lambda mesh: mass_properties(mesh, 400.0),
    "box_sides": box_sides,
    "rescale": lambda mesh: rescale(mesh, "paper", 0.075, 0.8),
    "convex_parts": lambda mesh: decompose(mesh, 64, 0.06),
    "stable_poses": lambda mesh: resting_poses(mesh, np.zeros(3)),
    "complexity": complexity,
    "graded": lambda mesh: measure_repeatably(mesh, select(SETTINGS, MeasureParameters), 10),
    "label": lambda mesh: Labeller(LABELS)(mesh, np.zeros(3), np.random.default_rng(0)),
    "suction": sample_suction,
    "extract": lambda mesh: reeb.extract(mesh, SETTINGS.similarity),
}
NO_MESH = {
    "scene": (trimesh.Scene(BOX), r"got Scene; `scene.to_mesh\(\)`"),
    "path": (Path("cup.obj"), "egad.read_mesh"),
    "name": ("cup.obj", "egad.read_mesh"),
    "nothing": (None, "got NoneType"),
    "array": (BOX.vertices, "got TrackedArray"),
}
UNUSABLE = {
    "not a number": (with_vertex(np.nan), "not finite"),
    "infinite": (with_vertex(np.inf), "not finite"),
    "empty": (trimesh.Trimesh(), "no faces"),
    "points": (raw(BOX.vertices, np.empty((0, 3), dtype=int)), "no faces"),
    "corner too high": (with_corner(8), "vertices that do not exist"),
    "corner too low": (with_corner(-1), "vertices that do not exist"),
}
NO_SOLID = {
    "open": (raw(BOX.vertices, BOX.faces[2:]), "open"),
    "inside out": (raw(BOX.vertices, BOX.faces[:, ::-1]), "inside out"),
    "flat": (raw(BOX.vertices @ FLATTEN, BOX.faces), "no volume"),
    "point": (raw(np.ones((3, 3)), [[0, 1, 2]]), "no area"),
}


@pytest.mark.parametrize("given", NO_MESH)
def test_what_is_not_a_mesh_is_refused_with_advice(given):
    argument, sentence = NO_MESH[given]
    with pytest.raises(UserError, match=f"a mesh must be a trimesh.Trimesh, .*{sentence}"):
        check_mesh(argument)


@pytest.mark.parametrize("given", UNUSABLE)
def test_an_unusable_mesh_is_rejected_with_the_reason(given):
    mesh, sentence = UNUSABLE[given]
    with pytest.raises(RejectedError, match=sentence):
        check_mesh(mesh)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_function_checks_its_mesh(function):
    with pytest.raises(UserError, match=r"a mesh must be a trimesh\.Trimesh"):
        FUNCTIONS[function](NO_MESH["scene"][0])
    with pytest.raises(RejectedError, match="vertices that do not exist"):
        FUNCTIONS[function](UNUSABLE["corner too high"][0])


@pytest.mark.parametrize("function", ["mass_properties", "label", "suction"])
@pytest.mark.parametrize("given", NO_SOLID)
def test_functions_of_solids_reject_other_surfaces(function, given):
    mesh, sentence = NO_SOLID[given]
    with pytest.raises(RejectedError, match=sentence):
        FUNCTIONS[function](mesh)


@pytest.mark.parametrize("function", sorted(FUNCTIONS.keys() - {"complexity", "extract"}))
@pytest.mark.parametrize("given", ["flat", "point"])
def test_a_mesh_without_volume_is_rejected(function, given):
    with pytest.raises(RejectedError):
        FUNCTIONS[function](NO_SOLID[given][0])


def test_a_solid_may_lie_far_away_and_touch_itself():
    """Vertices that are merged where two corners meet leave edges with four faces."""
    check_solid(BOX.copy().apply_translation([1e4, 0, 0]))
    pair = trimesh.util.concatenate([BOX, BOX.copy().apply_translation([0.02, 0.03, 0])])
    merged = raw(pair.vertices.round(6), pair.faces)
    merged.merge_vertices()
    assert not merged.is_watertight
    check_solid(merged)


@pytest.mark.parametrize(("side", "usual"), [(0.05, True), (50.0, False), (5e-5, False)])
def test_units_that_look_wrong_give_a_warning(side, usual):
    mesh = BOX.copy().apply_scale(side / 0.05)
    if usual:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_units(mesh)
    else:
        with pytest.warns(UnitsWarning, match=f"is {side:.3g} m, which .* really in metres"):
            check_units(mesh)


CRATE = trimesh.creation.box((20, 30, 50))


@pytest.mark.parametrize(
    "call",
    [
        lambda _: egad.rescale(CRATE, "panda"),
        lambda _: egad.sample_grasps(CRATE, "panda"),
        lambda _: egad.run_trials("random", {"crate": CRATE}, "panda", attempts=1),
        lambda _: egad.convex_parts(CRATE),
        lambda folder: egad.export({"crate": CRATE}, "obj", "panda", folder / "out"),
    ],
)
def test_the_warning_names_the_line_of_the_user(call, tmp_path):
    with pytest.warns(UnitsWarning) as found, contextlib.suppress(RejectedError):
        call(tmp_path)
    assert [(each.filename, each.lineno) for each in found] == [
        (__file__, call.__code__.co_firstlineno)
    ]
