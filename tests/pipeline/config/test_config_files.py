import copy
import json
from pathlib import Path

import jsonschema
import pytest
import yaml
from snakemake.utils import update_config

from egad._util.parameters import allowed
from egad.pipeline.config import Settings
from egad.pipeline.config import files as config_files
from egad.pipeline.config.check import check
from egad.pipeline.config.schema import node_at, schema
from egad.pipeline.config.training_study import networks_of, with_networks

ROOT = Path(__file__).parents[3]
DATASETS = ["datasets/ycb.yaml", "datasets/egad.yaml"]
STUDIES = ["training_study.yaml", "training_variance.yaml"]
FILES = [
    *("config.yaml", "paper.yaml", "first_edition.yaml", "full.yaml", "test.yaml"),
    *DATASETS,
    *STUDIES,
]


def load(name):
    return yaml.safe_load((ROOT / "config" / name).read_text())


@pytest.mark.parametrize("path", config_files.files(), ids=str)
def test_files_are_in_step_with_the_settings(path):
    current = (ROOT / path).read_text()
    assert current == config_files.files()[path], "run `python -m egad.pipeline.config.files`"


def test_check_option_finds_a_difference(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert config_files.main(["--check"]) == 1
    assert config_files.main([]) == 0
    assert config_files.main(["--check"]) == 0
    (tmp_path / "config/paper.yaml").write_text("seed: 1\n")
    capsys.readouterr()
    assert config_files.main(["--check"]) == 1
    assert capsys.readouterr().out.startswith("config/paper.yaml is not up to date")


def test_the_default_file_holds_every_setting_at_its_default():
    loaded = load("config.yaml")
    assert check(loaded) == Settings()
    everything = json.loads(Settings().model_dump_json(exclude_none=True))
    assert loaded == everything


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
    assert config_files.merged(load("config.yaml"), changes) == by_snakemake


def test_every_setting_has_a_comment_above_it():
    lines = (ROOT / "config/config.yaml").read_text().splitlines()
    tables = lines.index("grippers:")
    settings = [i for i, line in enumerate(lines[:tables]) if ":" in line and "#" not in line]
    inside_datasets = {i for i in settings if lines[i].strip() in ("egad:", "source: evolved")}
    for i in set(settings) - inside_datasets:
        assert lines[i - 1].lstrip().startswith("#"), lines[i]


@pytest.mark.parametrize("name", FILES)
def test_files_obey_the_schema_that_editors_use(name):
    jsonschema.validate(load(name), schema(), cls=jsonschema.Draft202012Validator)
    assert schema()["$schema"].endswith("2020-12/schema")


def test_the_schema_refuses_what_the_settings_refuse():
    for wrong in ({"sed": 1}, {"seed": "1"}, {"evolution": {"population": 0}}, {"neat": 3}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema())


@pytest.mark.parametrize("name", FILES)
def test_the_head_of_a_file_names_the_schema_beside_it(name):
    path = ROOT / "config" / name
    target = path.read_text().splitlines()[0].removeprefix("# yaml-language-server: $schema=")
    assert (path.parent / target).resolve() == (ROOT / config_files.SCHEMA).resolve()


@pytest.mark.parametrize("name", DATASETS)
def test_a_dataset_of_others_stands_alone_or_beside_the_evolved_one(name):
    alone, beside = check(load(name)), check(merged(load("config.yaml"), load(name)))
    assert [dataset.source for dataset in alone.datasets.values()] == ["meshes"]
    assert [dataset.source for dataset in beside.datasets.values()] == ["evolved", "meshes"]
    assert alone.targets.datasets == beside.targets.datasets == list(alone.datasets)


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_can_be_run_over_the_defaults(name):
    settings = check(merged(load("config.yaml"), load(name)))
    names = [network.name for network in networks_of(settings)]
    assert len(names) == len(set(names)) > len(settings.training_study.sets)
    with_networks(settings)


def merged(below, above):
    """As Snakemake lays one file over another."""
    both = below.keys() & above.keys()
    inner = {
        key: merged(below[key], above[key]) if isinstance(above[key], dict) else above[key]
        for key in both
    }
    return below | above | inner


def test_paper_is_table_two():
    paper = check(load("paper.yaml"))
    steps = paper.schedule.epochs * paper.evolution.steps_per_epoch
    assert (steps, steps * paper.evolution.population) == (2000, 200_000)
    assert paper.schedule.islands == 1
    assert (paper.space.cells, paper.space.elites_per_cell, paper.space.neighbors) == (25, 4, 10)
    assert paper.space.difficulty_range == (0.0005, 0.004)
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
    steps = full.schedule.epochs * full.evolution.steps_per_epoch * full.schedule.islands
    assert steps * full.evolution.population == 200_000
    changed = full.evolution.model_copy(update={"steps_per_epoch": usual.evolution.steps_per_epoch})
    assert changed == usual.evolution
    assert (full.difficulty, full.space) == (usual.difficulty, usual.space)


def test_paper_states_every_parameter_of_table_two_itself():
    """So that it is the paper's even over a config.yaml that somebody changed."""
    stated = load("paper.yaml")
    for section, key in [
        ("evolution", "population"),
        ("space", "difficulty_range"),
        ("evolution", "grasps"),
        ("complexity", "bins"),
        ("shape", "resolution"),
    ]:
        assert key in stated[section]


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (("seed",), "a whole number, at least 0, below 4294967296"),
        (("schedule", "epochs"), "a whole number, 1 to 200"),
        (("grippers", "any", "opening"), "a number, above 0, at most 10"),
        (("similarity", "bases"), "even or scan"),
        (("space", "complexity_range"), "a list of 2, each a number"),
        (("datasets", "any", "folder"), "a text or nothing"),
        (("targets", "grippers", 0), "a name of small letters, digits, _ and -"),
    ],
)
def test_allowed_says_the_limits(path, words):
    assert allowed(node_at(path)) == words


def test_no_node_where_there_is_no_setting():
    assert node_at(("seed", "deeper")) is None
    assert node_at(("evolution", "poplation")) is None
