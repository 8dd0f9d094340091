"""Models: true mass, center of mass and inertia, in the principal frame."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.geometry import Bundle, MassProperties
from egad.sim.model import MIN_MASS, build, principal_frame

BUNDLE = Bundle()
SIDES = np.array([0.08, 0.05, 0.03])


def tilted_box() -> trimesh.Trimesh:
    box = trimesh.creation.box(SIDES)
    box.apply_transform(trimesh.transformations.euler_matrix(0.3, 0.5, 0.7))
    return box.apply_translation((0.1, -0.2, 0.3))


def test_mass_and_inertia_of_a_box() -> None:
    model = build(tilted_box(), 1000.0, BUNDLE)
    mass = 1000 * SIDES.prod()
    squares = SIDES**2
    expected = np.sort(mass / 12 * (squares.sum() - squares))
    assert model.mass == pytest.approx(mass)
    np.testing.assert_allclose(model.inertia, expected, rtol=1e-9)


def test_mesh_and_parts_lie_in_the_principal_frame() -> None:
    model = build(tilted_box(), 1000.0, BUNDLE)
    for mesh in (model.mesh, *model.parts):
        np.testing.assert_allclose(mesh.center_mass, 0, atol=1e-9)
        # The longest side has the smallest moment, which comes first.
        np.testing.assert_allclose(mesh.extents, SIDES, rtol=1e-6)
        assert mesh.volume == pytest.approx(SIDES.prod(), rel=1e-6)


def test_a_light_object_gets_the_least_mass_and_keeps_its_form() -> None:
    light, heavy = build(tilted_box(), 1.0, BUNDLE), build(tilted_box(), 1000.0, BUNDLE)
    assert light.mass == MIN_MASS
    np.testing.assert_allclose(light.inertia / light.mass, heavy.inertia / heavy.mass)


def test_inside_out_is_mended_and_the_input_left_alone() -> None:
    mesh = tilted_box()
    mesh.invert()
    before = mesh.vertices.copy(), mesh.faces.copy()
    model = build(mesh, 1000.0, BUNDLE)
    assert model.mesh.volume > 0
    assert model.volume_error == pytest.approx(0, abs=1e-6)
    np.testing.assert_array_equal(mesh.vertices, before[0])
    np.testing.assert_array_equal(mesh.faces, before[1])


def test_a_scaled_object_is_that_of_the_scaled_mesh() -> None:
    box = tilted_box()
    scaled = build(box, 1000.0, BUNDLE).scaled(1.5)
    expected = build(box.copy().apply_scale(1.5), 1000.0, BUNDLE)
    assert scaled.mass == pytest.approx(expected.mass)
    np.testing.assert_allclose(scaled.inertia, expected.inertia, rtol=1e-9)
    np.testing.assert_allclose(scaled.mesh.extents, expected.mesh.extents, rtol=1e-9)
    for part in scaled.parts:
        np.testing.assert_allclose(part.extents, 1.5 * SIDES, rtol=1e-6)
    # It maps the frame of the given mesh to that of the model, of its new size.
    mapped = box.copy().apply_transform(scaled.to_principal)
    np.testing.assert_allclose(mapped.vertices, scaled.mesh.vertices, atol=1e-9)


def test_a_scaled_object_is_not_lighter_than_the_least_mass() -> None:
    small = build(tilted_box(), 1000.0, BUNDLE).scaled(0.5)
    assert small.mass == MIN_MASS


def test_a_light_object_that_grows_has_the_mass_of_the_larger_solid() -> None:
    """It weighs 48 g, which counts as 50 g; twice as large, it weighs eight times 48 g."""
    grown = build(tilted_box(), 400.0, BUNDLE).scaled(2.0)
    assert grown.mass == pytest.approx(8 * 400 * SIDES.prod())
    expected = build(tilted_box().apply_scale(2.0), 400.0, BUNDLE)
    np.testing.assert_allclose(grown.inertia, expected.inertia, rtol=1e-9)


@pytest.mark.parametrize(
    "moments", [(1.0, 2.0, 2.5), (1.0, 1.0, 1.5), (2.0, 2.0, 2.0), (1.0, 1.0, 2.0)]
)
def test_principal_axes_are_those_of_lapack(moments: tuple[float, float, float]) -> None:
    for turn in (Rotation.identity(), *Rotation.random(20, rng=np.random.default_rng(0))):
        matrix = turn.as_matrix()
        inertia = 1e-5 * matrix @ np.diag(moments) @ matrix.T
        physics = MassProperties(1e-3, 0.1, np.zeros(3), 1.0, (inertia + inertia.T) / 2)
        found, frame = principal_frame(physics)
        axes = frame[:3, :3]
        np.testing.assert_allclose(found, np.linalg.eigvalsh(inertia), rtol=1e-10)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(axes) > 0
        np.testing.assert_allclose(axes.T @ np.diag(found) @ axes, inertia, atol=1e-18)
        largest = np.abs(axes[:2]).argmax(axis=1)
        assert (axes[[0, 1], largest] > 0).all()
