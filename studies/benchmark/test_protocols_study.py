"""The objects of protocols.md have the sizes of NeuGraspNet."""

from pathlib import Path

import numpy as np
import protocols
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.bench.preparation import SceneObject
from egad.geometry import Bundle
from egad.sim import build


@pytest.fixture(scope="module")
def study():
    return vars(protocols)


def slowly(mesh, turn, scale):
    """As the repository does it: an object is made, its box is looked at, and it is thrown away."""
    factor = scale
    while True:
        there = mesh.copy()
        there.apply_transform(turn)
        there.apply_scale(factor)
        sides = sorted(there.bounds[1] - there.bounds[0])
        if sides[1] > 0.15 * scale:
            factor = factor * 0.8
        elif sides[0] * sides[1] * sides[2] > 0.0006 * scale * scale * scale:
            factor = factor * 0.85
        elif sides[0] < 0.014 * scale:
            factor = factor / 0.95
        else:
            return factor


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.4])
def test_a_cube_ends_at_72_to_84_mm(study, scale):
    """0.6 litres are a cube of 84.3 mm, and the last step was one by 0.85 from above that."""
    corners = trimesh.creation.box((1, 1, 1)).vertices
    ends = [
        side * study["scale_factor"](side * corners, scale) for side in np.linspace(80, 120, 60)
    ]
    assert 0.0716 * scale < min(ends) < 0.073 * scale
    assert 0.083 * scale < max(ends) < 0.0844 * scale


@pytest.mark.parametrize("sides", [(100, 80, 60), (100, 100, 4), (100, 12, 9), (99, 100, 98)])
def test_sizes_are_those_of_a_slow_loop(study, sides):
    mesh, rng = trimesh.creation.box(sides), np.random.default_rng(0)
    for _ in range(5):
        turn, scale = np.eye(4), rng.uniform(0.8, 1.4)
        turn[:3, :3] = Rotation.random(rng=rng).as_matrix()
        vertices = mesh.vertices @ turn[:3, :3].T
        expected = slowly(mesh, turn, scale)
        assert study["scale_factor"](vertices, scale) == pytest.approx(expected, rel=1e-12)


def test_objects_that_cannot_have_a_size_end_the_loop(study):
    with pytest.raises(ValueError, match="no size"):
        study["scale_factor"](np.array([[0.0, 0.0, 0.0], [100.0, 100.0, 0.0]]), 1.0)


def test_changes_do_what_they_say(study):
    """A ring whose hole the hull fills, in six sizes, of 150 g."""
    ring = trimesh.creation.annulus(0.02, 0.03, 0.02)
    known = [SceneObject("ring", build(ring, 400.0, Bundle()), None)]
    made = list(study["changed"](known, ("sizes", "hulls", "mass")))
    assert [each.id for each in made] == [f"ring-{number}" for number in range(6)]
    assert len({each.model.mesh.scale for each in made}) == 6
    for each in made:
        model = each.model.scaled(0.9)
        assert model.mass == each.model.mass == 0.15
        (hull,) = model.parts
        assert hull.volume == pytest.approx(model.mesh.convex_hull.volume)
        assert model.mesh.volume < 0.7 * hull.volume  # the camera sees the hole
        assert model.inertia.sum() == pytest.approx(0.81 * each.model.inertia.sum())
    (same,) = study["changed"](known, ())
    assert same.model is known[0].model


def test_steps_add_up(study):
    runs = study["piles"](Path("out"))
    last = runs["together-pybullet"]
    assert last.changes == ("sizes", "hulls", "mass")
    assert (last.fine, last.clutter.engine, last.clutter.noise) == (True, "pybullet", ("none",))
    rules = last.clutter.protocol
    assert (rules.skips, rules.threshold, rules.force, rules.cameras.views) == (3, 0.5, 20.0, 1)
    alone = runs["alone-skips"]
    assert alone.clutter.protocol == study["OURS"].model_copy(update={"skips": 3})
    assert runs["egad"].clutter.protocol == study["OURS"]
