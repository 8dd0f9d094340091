"""Every example of config/examples, evolved for a few steps: its constraint holds."""

from functools import lru_cache
from pathlib import Path

import jsonschema
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
    "evolution": {"evaluations": 60, "population": 30, "max_candidates": 256},
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


def test_shapes_stay_in_the_bottle():
    bottle = trimesh.load_mesh("examples/bottle.obj")
    middle = bottle.bounds.mean(axis=0)
    inside = bottle.contains(voxel_middles(25) * bottle.extents.max() + middle)
    assert 0.05 < inside.mean() < 0.2
    for voxels in evolved("bottle")[2]:
        assert (voxels.ravel() & ~inside).sum() <= 2  # middles on the surface


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
