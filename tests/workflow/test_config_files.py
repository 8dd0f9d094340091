import copy
from pathlib import Path

import jsonschema
import manual
import pytest
from snakemake.utils import update_config

from egad._util.parameters import allowed
from egad_workflow import config_files as files
from egad_workflow.check import check, node_at, schema
from egad_workflow.config_files import merged
from egad_workflow.settings import Settings

ROOT = Path(__file__).parents[2]
DATASETS = ["datasets/ycb.yaml", "datasets/egad.yaml"]
FILES = [
    *("config.yaml", "paper.yaml", "first_edition.yaml", "full.yaml", "test.yaml"),
    *DATASETS,
]


def load(name):
    return files.read_values(ROOT / "config" / name)


def test_the_default_file_changes_nothing():
    """It has what people change first; each value is that of the settings."""
    assert check(load("config.yaml")) == Settings()
    assert check({}) == Settings()


def test_every_file_is_valid_over_the_default_one():
    found = sorted((ROOT / "config").rglob("*.yaml"))
    assert len(found) > len(FILES)
    for path in found:
        check(merged(load("config.yaml"), load(path)))


def test_the_manual_lists_every_setting(monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("sys.argv", ["manual", "--check"])
    manual.main()
    text = (ROOT / "config/README.md").read_text()
    for section, values in files.defaults().items():
        assert f"`{section}`" in text
        if isinstance(values, dict) and section not in (*files.BUILT_IN, "datasets"):
            part = text.partition(f"### `{section}`\n")[2].partition("\n### ")[0]
            if "The keys are those of the section above." not in part:
                listed = part
            assert [key for key in values if f"| `{key}` |" not in listed] == []


def test_built_in_entries_stay_beside_those_of_the_user():
    own = check({"grippers": {"mine": {"opening": 0.065}, "panda": {"force": 20.0}}}).grippers
    usual = Settings().grippers
    assert [*usual, "mine"] == list(own)
    assert own["panda"] == usual["panda"].model_copy(update={"force": 20.0})
    assert own["yumi"] == usual["yumi"]
    detectors = check({"detectors": {"mine": {"command": ["./detect"]}}}).detectors
    assert detectors.keys() - {"mine"} == Settings().detectors.keys()


CHANGES = [
    {},
    {"grippers": {"panda": {"force": 20.0}, "mine": {"opening": 0.065}}},
    {"datasets": {"egad": {"source": "archive", "archive": "released"}}},
    {"space": {"cells": 10}, "targets": {"grippers": ["yumi", "panda"]}, "seed": 3},
    {"print_check": None, "measures": {"complexity": "a.py:b"}, "unknown": {"key": {"of": [1]}}},
]


@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_files_are_merged_as_snakemake_merges_them(changes):
    by_snakemake = load("config.yaml")
    update_config(by_snakemake, copy.deepcopy(changes))
    assert merged(load("config.yaml"), changes) == by_snakemake


@pytest.mark.parametrize("name", FILES)
def test_files_obey_the_schema(name):
    jsonschema.validate(load(name), schema(), cls=jsonschema.Draft202012Validator)
    assert schema()["$schema"].endswith("2020-12/schema")


def test_the_schema_refuses_what_the_settings_refuse():
    for wrong in ({"sed": 1}, {"seed": "1"}, {"evolution": {"population": 0}}, {"neat": 3}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema())


@pytest.mark.parametrize("name", DATASETS)
def test_a_dataset_of_others_stands_alone_or_beside_the_evolved_one(name):
    alone, beside = check(load(name)), check(merged(load("config.yaml"), load(name)))
    assert [dataset.source for dataset in alone.datasets.values()] == ["meshes"]
    assert [dataset.source for dataset in beside.datasets.values()] == ["evolved", "meshes"]
    assert alone.targets.datasets == beside.targets.datasets == list(alone.datasets)


def test_paper_is_table_two():
    paper = check(load("paper.yaml"))
    steps = paper.epochs * paper.evolution_of_epoch.steps
    assert (steps, steps * paper.evolution.population) == (2000, 200_000)
    assert paper.schedule.islands == 1
    assert (paper.space.cells, paper.space.elites_per_cell, paper.space.neighbors) == (25, 4, 10)
    assert paper.space.graspability_range == (0.0005, 0.004)
    assert paper.space.complexity_range == (1, 5)
    assert paper.evolution.crossover_probability == 0.5
    assert (paper.complexity.bins, paper.evolution.grasps) == (512, 100)
    assert paper.shape.resolution == 25
    assert paper.space.confidence == Settings().space.confidence  # for objects, measured as usual


def test_the_first_edition_is_the_paper_with_another_way_to_draw_parents():
    paper, first = load("paper.yaml"), load("first_edition.yaml")
    assert first["evolution"].pop("parents") == "sparse"
    assert paper["evolution"].pop("parents") == "uniform"
    assert first == paper


def test_full_is_the_default_search_with_the_evaluations_of_the_paper():
    full, usual = check(load("full.yaml")), Settings()
    assert (full.epochs, full.evolution_of_epoch.evaluations) == (20, 10_000)
    assert full.evolution.evaluations == 200_000
    changed = full.evolution.model_copy(update={"evaluations": usual.evolution.evaluations})
    assert changed == usual.evolution
    assert (full.graspability, full.space) == (usual.graspability, usual.space)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (("seed",), "a whole number, at least 0, below 4294967296"),
        (("schedule", "epochs"), "a whole number, 1 to 200 or nothing"),
        (("grippers", "any", "opening"), "a number, above 0, at most 10"),
        (("similarity", "bases"), "even or scan"),
        (("space", "complexity_range"), "a list of 2, each a number"),
        (("datasets", "any", "folder"), "a text or nothing"),
        (("targets", "grippers", 0), "a name of lowercase letters, digits, _ and -"),
    ],
)
def test_allowed_says_the_limits(path, words):
    assert allowed(node_at(path)) == words
