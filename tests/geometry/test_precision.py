import numpy as np
import pytest
import trimesh

import egad
from egad.evolution.surface import surface
from egad.geometry import rescale
from egad.geometry.repair import repair, repair_for_files
from egad.geometry.rounding import is_single, to_single

BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.0517)
ROUNDED = repair_for_files(BALL).mesh
SOME, ALL = slice(None, None, 220), slice(None)


def test_rounding_is_that_of_the_files():
    values = np.random.default_rng(0).normal(size=1000)
    rounded = to_single(values)
    assert np.array_equal(rounded, values.astype(np.float32))
    assert is_single(rounded)
    assert not is_single(values)
    assert np.abs(rounded / values - 1).max() <= 2**-24


def test_what_is_too_large_is_not_single():
    assert not is_single([1e39])
    assert to_single([1e39])[0] == np.inf


def test_a_repaired_mesh_is_rounded_and_keeps_its_faces():
    exact, rounded = repair(BALL), repair_for_files(BALL)
    assert not is_single(exact.mesh.vertices)
    assert np.array_equal(rounded.mesh.vertices, to_single(exact.mesh.vertices))
    assert np.array_equal(rounded.mesh.faces, exact.mesh.faces)
    assert rounded._replace(mesh=None) == exact._replace(mesh=None)


def test_what_was_mended_is_rounded_too():
    other = BALL.copy().apply_translation((0.03, 0.01, 0.02))
    found = repair_for_files(trimesh.util.concatenate([BALL, other]))
    assert found.changed
    assert is_single(found.mesh.vertices)
    assert repair(found.mesh).changed is False


def test_details_that_rounding_would_destroy_stay_as_they_are():
    far = BALL.copy().apply_translation((1e6, 0, 0))
    found = repair_for_files(far).mesh
    assert np.array_equal(found.vertices, repair(far).mesh.vertices)


def test_scaling_keeps_single_precision_and_doubles():
    for mesh in (BALL, ROUNDED):
        scaled, row = rescale(mesh, "exact", 0.05, 0.8)
        exact = np.asarray(mesh.vertices) * row["factor"]
        single = is_single(mesh.vertices)
        assert np.array_equal(scaled.vertices, to_single(exact) if single else exact)


@pytest.mark.parametrize("chosen", [SOME, pytest.param(ALL, marks=pytest.mark.slow)])
def test_released_objects_keep_their_topology(chosen):
    for each in list(egad.load("released"))[chosen]:
        exact = repair(surface(each.voxels, each.shape)).mesh
        check_rounded(each.mesh, exact)
        scaled, factor = egad.rescale(each.mesh, "egad_75mm")
        assert is_single(scaled.vertices)
        check_rounded(scaled, exact.copy().apply_scale(factor))


def check_rounded(mesh, exact):
    """Nothing but the last digits of the coordinates is different."""
    assert is_single(mesh.vertices)
    assert np.array_equal(mesh.faces, exact.faces)
    assert np.abs(mesh.vertices - exact.vertices).max() < 1e-8
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert mesh.area_faces.min() > 0
    assert mesh.is_watertight
    assert not repair(mesh).changed  # it neither crosses itself nor has another body


def test_the_library_measures_what_a_dataset_would_publish():
    """So it has the values that `egad measure` and tables have."""
    raw, published = (egad.measure(each, max_candidates=512) for each in (BALL, ROUNDED))
    assert raw == published
