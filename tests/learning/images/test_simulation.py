"""Objects in other sizes rest where they are put, weigh what they should, and are grasped alike."""

import numpy as np
import pytest
import trimesh

from egad.grasps import ContactPairs
from egad.learning.images import model_at_size, settle_scene, simulate_contacts
from egad.sim.parameters import SimulatedLabelParameters
from egad_workflow.settings import Settings, select

DENSITY = 400.0
SETTINGS = select(Settings(), SimulatedLabelParameters, "egad_75mm")


@pytest.fixture(scope="module")
def block():
    """Not around its origin."""
    return trimesh.creation.box((0.06, 0.1, 0.08)).apply_translation((0.03, 0.02, 0.05))


def across(mesh, offset=0.0):
    """A grasp across the narrow sides of a block, from above, and where its middle is along y."""
    low, high = mesh.bounds
    middle = (low + high) / 2 + [0, offset, 0]
    points = np.array([[[low[0], *middle[1:]], [high[0], *middle[1:]]]])
    axis = np.array([[1.0, 0, 0]])
    return ContactPairs(points, np.stack([-axis, axis], axis=1), axis), np.array([[0, 0, -1.0]])


@pytest.mark.parametrize("factor", [0.5, 1.0])
def test_a_scaled_object_weighs_as_one_of_that_size(block, factor):
    model = model_at_size(block, [block], factor, DENSITY)
    sides = factor * np.array([0.06, 0.1, 0.08])
    assert model.solid_mass == pytest.approx(DENSITY * sides.prod())
    ends = trimesh.transform_points(factor * block.vertices, model.to_principal)
    np.testing.assert_allclose(ends.mean(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.sort(np.ptp(ends, axis=0)), np.sort(sides), rtol=1e-9)


def test_a_grasp_in_the_middle_holds_and_one_beside_the_object_does_not(block):
    small = block.copy().apply_scale(0.5)
    model = model_at_size(block, [block], 0.5, DENSITY)
    pairs = [across(small), across(small, offset=0.2)]
    found = [simulate_contacts(model, *each, SETTINGS) for each in pairs]
    assert found == [[True], [False]]


@pytest.mark.parametrize("kind", ["packed", "pile"])
def test_objects_come_to_rest_on_the_table_or_on_each_other(block, kind):
    """Frames are those of the scaled meshes: at rest nothing is below the table."""
    factors = [0.5, 0.3, 0.4]
    models = [model_at_size(block, [block], factor, DENSITY) for factor in factors]
    placed = settle_scene(models, kind, "mujoco", np.random.default_rng(0))
    assert len(placed) > 1
    for number, matrix in placed:
        corners = trimesh.transform_points(factors[number] * block.vertices, matrix)
        np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-9)
        assert corners[:, 2].min() > -0.002
        if kind == "packed":
            assert corners[:, 2].min() < 0.002
    again = settle_scene(models, kind, "mujoco", np.random.default_rng(0))
    assert [number for number, _ in again] == [number for number, _ in placed]
    np.testing.assert_array_equal([each for _, each in again], [each for _, each in placed])
