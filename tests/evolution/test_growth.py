"""Meshes of genomes at any resolution."""

import numpy as np
import pytest

import egad
from egad.errors import UserError
from egad.evolution import (
    Envelope,
    Shape,
    check_regrown,
    evolution_parameters,
    genome_mesh,
    rules_of,
)
from egad.evolution.growth import grow, surface

BALL = {  # output = 0.5 + 0.8 - r, above the threshold within 0.8 of the center
    "node_keys": [0],
    "node_biases": [1.3],
    "node_activations": ["identity"],
    "connection_sources": [-7],
    "connection_targets": [0],
    "connection_weights": [-1.0],
    "connection_enabled": [True],
}


@pytest.fixture(scope="module")
def objects():
    return egad.load("released")


def test_a_ball_converges_to_a_ball():
    """Its voxels to the true volume; the mesh, whose poles stick out by a voxel, more slowly."""
    exact, errors = 4 / 3 * np.pi * 0.8**3, []
    for resolution in (12, 25, 50, 100):
        volume = grow(BALL, resolution).sum() * (2 / (resolution - 1)) ** 3
        errors.append(abs(volume / exact - 1))
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.005
    mesh = genome_mesh(BALL, 100)
    assert mesh.is_watertight
    assert mesh.extents == pytest.approx([0.1] * 3, rel=1e-6)
    assert mesh.volume == pytest.approx(np.pi / 6 * 0.1**3, rel=0.05)


def test_voxels_of_released_genomes_converge(objects):
    for label in ("C11_1", "M14_3"):
        each = objects[label]
        coarse, fine, finest = (
            grow(each.genome, resolution).mean() for resolution in (25, 50, 100)
        )
        assert abs(finest - fine) < abs(fine - coarse) < 0.06


def test_the_resolution_of_the_archive_gives_its_mesh(objects):
    each = objects["M14_3"]
    same = each.mesh_at(25)
    assert np.array_equal(same.vertices, each.mesh.vertices)
    assert np.array_equal(same.faces, each.mesh.faces)
    assert np.array_equal(grow(each.genome, 25), each.voxels)


def test_constraints_that_nobody_named_are_noticed(objects):
    each = objects["M14_3"]
    envelope = {"envelope": Envelope(kind="box", size=(1, 1, 0.6))}
    rules = rules_of(evolution_parameters(0).model_copy(update=envelope), 25)
    bounded = grow(each.genome, 25, rules=rules)
    check_regrown(each.genome, bounded, 0.5, rules)
    with pytest.raises(UserError, match="evolved under constraints"):
        check_regrown(each.genome, bounded, 0.5)


@pytest.mark.parametrize("resolution", [7, 201, 0, 30.5, "fine", True])
def test_other_resolutions_are_refused(objects, resolution):
    for use in (objects["M14_3"].mesh_at, lambda each: genome_mesh(BALL, each)):
        with pytest.raises(UserError, match="resolution is"):
            use(resolution)


SHAPE = Shape()


def ball(size=25):
    line = np.linspace(-1, 1, size)
    x, y, z = np.meshgrid(line, line, line, indexing="ij")
    return x**2 + y**2 + z**2 < 0.8


def test_a_ball_is_a_watertight_ball_with_outward_normals():
    mesh = surface(ball(), SHAPE)
    assert mesh.is_watertight
    assert mesh.extents.max() == pytest.approx(SHAPE.longest_side)
    assert np.allclose(mesh.bounds.sum(axis=0), 0, atol=1e-12)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.05)  # inside out: negative
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.triangles_center)
    assert (outward > 0).all()


def test_a_solid_that_touches_the_border_is_closed():
    mesh = surface(np.ones((8, 8, 8), bool), SHAPE)
    assert mesh.is_watertight
    assert mesh.euler_number == 2
