"""Scenes of boxes, made once."""

import pytest
from small_scenes import BOXES, SPLIT_OF, parameters

from egad.geometry import Bundle
from egad.learning.scenes import load_scenes, make_scene, planned_scenes, set_notes, write_shard
from egad.sim import build


@pytest.fixture(scope="session")
def models():
    return {name: build(mesh, 300.0, Bundle()) for name, mesh in BOXES.items()}


@pytest.fixture(scope="session")
def settings():
    return parameters()


@pytest.fixture(scope="session")
def plan(settings):
    return planned_scenes(SPLIT_OF, settings)


@pytest.fixture(scope="session")
def made(plan, models, settings):
    return [make_scene(each, models, settings) for each in plan]


@pytest.fixture
def write(made, settings, tmp_path):
    """Writes some scenes to a folder, in any number of shards, whose numbers they end with."""

    def written(*shards, scenes=made, folder=tmp_path):
        about = set_notes(settings, SPLIT_OF, "panda")
        for number, part in enumerate(shards):
            files = (folder / f"{name}-{number}.parquet" for name in ("scenes", "grasps"))
            write_shard([scenes[index] for index in part], number, len(shards), about, *files)
        return folder

    return written


@pytest.fixture
def dataset(write):
    return load_scenes(write([0, 1], [2, 3]))
