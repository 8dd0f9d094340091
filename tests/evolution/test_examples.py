"""Every example of config/examples, evolved for a few steps: its constraint holds."""

from functools import lru_cache
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import trimesh
import yaml

from egad.evolution import (
    Archive,
    EvolutionParameters,
    PostprocessSolids,
    evolve,
    packed_surface,
    rules_of,
    unpack,
)
from egad.evolution.constraints import voxel_middles
from egad.evolution.voxels import largest_body
from egad.geometry.repair import repair
from egad.measures import measure_repeatably
from egad.measures.custom import plugin_value
from egad.measures.graspability import rough_graspability
from egad.random import generator
from egad_workflow.check import check, schema
from egad_workflow.settings import select

ROOT = Path(__file__).parents[2]
EXAMPLES = {path.stem: path for path in sorted((ROOT / "config/examples").glob("*.yaml"))}
QUICK = {
    "evolution": {"evaluations": 120, "population": 30, "max_candidates": 256},
    "postprocess": {"max_candidates": 256},
    "similarity": {"vertices": 300, "ranges": 16, "base_count": 8},
}


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def configured(name):
    values = yaml.safe_load(EXAMPLES[name].read_text())
    return check(values | QUICK)


@lru_cache
def evolved(name):
    """The archive, the settings, and the voxels of all elites."""
    config = configured(name)
    settings = select(config, EvolutionParameters)
    archive = Archive(settings.space, settings.similarity)
    evolve(archive, settings, 0, 0, rules_of(settings))
    assert len(archive) >= 3
    return archive, config, [unpack(each.voxels, 25) for each in archive.elites]


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_valid_and_says_how_it_is_run(name):
    values = yaml.safe_load(EXAMPLES[name].read_text())
    check(values)
    jsonschema.validate(values, schema(), cls=jsonschema.Draft202012Validator)
    assert f"--configfile config/examples/{name}.yaml" in EXAMPLES[name].read_text()


def test_every_example_is_shown():
    page = (ROOT / "docs/custom.md").read_text()
    for name in EXAMPLES:
        assert f"config/examples/{name}.yaml" in page
        assert f"custom-{name}.png" in page
        assert (ROOT / f"docs/custom-{name}.png").stat().st_size < 50_000


@pytest.mark.parametrize("name", sorted(set(EXAMPLES) - {"friction", "measures"}))
def test_every_shape_is_one_body(name):
    for voxels in evolved(name)[2]:
        assert np.array_equal(voxels, largest_body(voxels))


def test_shapes_stay_in_the_cylinder():
    x, y, _ = voxel_middles(25).T
    outside = (x**2 + y**2 > 0.25**2 + 1e-9).reshape(25, 25, 25)
    assert not any((voxels & outside).any() for voxels in evolved("envelope")[2])


def test_shapes_stay_in_the_bottle():
    bottle = trimesh.load_mesh("examples/bottle.obj")
    middle = bottle.bounds.mean(axis=0)
    inside = bottle.contains(voxel_middles(25) * bottle.extents.max() + middle)
    assert 0.05 < inside.mean() < 0.2
    for voxels in evolved("bottle")[2]:
        assert (voxels.ravel() & ~inside).sum() <= 2  # middles on the surface


def test_shapes_are_mirror_images_of_themselves():
    for voxels in evolved("mirror")[2]:
        assert np.array_equal(voxels, voxels[::-1])
        assert np.array_equal(voxels, voxels[:, ::-1])


def test_shapes_repeat_themselves():
    angle = 2 * np.pi / 5
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    covered = []
    for voxels in evolved("turn")[2]:
        places = np.argwhere(voxels)
        turned = np.rint((places[:, :2] - 12) @ turn + 12).astype(int)
        covered.append(voxels[turned[:, 0], turned[:, 1], places[:, 2]].mean())
    assert min(covered) >= 0.5  # a turn by a fifth does not carry voxels onto voxels
    assert np.median(covered) > 0.95


def test_every_tool_has_its_handle():
    x, y, z = voxel_middles(25).T
    handle = ((x**2 + y**2 <= 0.08**2 + 1e-9) & (z <= 0.2)).reshape(25, 25, 25)
    below = (z < 0).reshape(25, 25, 25)
    for voxels in evolved("handle")[2]:
        assert voxels[handle].all()
        assert not (voxels & below & ~handle).any()


def test_every_ring_is_open():
    x, y, z = voxel_middles(25).T
    radius = np.hypot(x, y)
    bore = (radius < 0.2 - 1e-9).reshape(25, 25, 25)
    tube = ((radius > 0.2 + 1e-9) & (radius < 0.3) & (abs(z) < 0.1)).reshape(25, 25, 25)
    for voxels in evolved("hole")[2]:
        assert not (voxels & bore).any()
        assert voxels[tube].all()


def test_limits_are_kept():
    for voxels in evolved("limits")[2]:
        sides = np.sort(np.ptp(np.argwhere(voxels), axis=0) + 1)
        assert 2 <= sides[2] / sides[0] <= 6
        assert 0.1 <= voxels.sum() / sides.prod() <= 0.7


def test_the_coordinates_are_the_measures_in_archive_and_dataset():
    archive, config, _ = evolved("measures")
    for each in archive.elites[:2]:
        mesh = packed_surface(each.voxels, config.shape)
        assert each.complexity == plugin_value(config.measures.complexity, mesh)
        assert each.graspability == plugin_value(config.measures.graspability, mesh)
        settings = select(config, PostprocessSolids)
        solid = repair(mesh).mesh
        place = measure_repeatably(solid, settings, settings.postprocess.max_candidates)
        assert place.complexity == pytest.approx(each.complexity, rel=1e-6)
        assert place.graspability == pytest.approx(each.graspability, abs=1e-6)
        assert place.grasps == 0


def test_slippery_fingers_make_the_same_shape_harder():
    config = configured("friction")
    assert config.quality.friction < 0.5
    mesh = trimesh.creation.icosphere(3, 0.05)
    slippery = select(config, EvolutionParameters)
    sticky = slippery.model_copy(
        update={"quality": config.quality.model_copy(update={"friction": 0.5})}
    )
    hard, easy = (rough_graspability(mesh, each, generator(0, "x")) for each in (slippery, sticky))
    assert hard.value < easy.value
