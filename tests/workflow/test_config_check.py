import copy
import importlib.util

import pytest

from egad.errors import UserError
from egad.grippers import GRIPPERS
from egad_workflow.check import check, check_engines
from egad_workflow.settings import Settings


def problems(config):
    with pytest.raises(UserError) as caught:
        check(config)
    return str(caught.value).splitlines()


def test_nothing_said_is_the_default():
    assert check({}) == Settings()


def test_the_configuration_itself_is_not_changed():
    config = {"sed": 1, "datasets": {"Bad Name": {"source": "evolved"}}, "neat": 3}
    before = copy.deepcopy(config)
    problems(config)
    assert config == before


def test_every_problem_has_one_line():
    found = problems(
        {
            "sed": 1,
            "shards": 0,
            "evolution": {"poplation": 5, "crossover_probability": 2},
            "space": {"cells": 0, "complexity_range": [5, 1]},  # seen once the cells are right
            "datasets": {"mine": {"source": "meshes"}, "two": {"source": "evolved"}},
            "targets": {"grippers": ["yumy"]},
            "grippers": {"yumi": {"opening": 0.05}, "wide": {}},
        }
    )
    starts = [
        "datasets.mine: a dataset with source `meshes` needs `folder`",
        "evolution.crossover_probability: 2 is not allowed; allowed: a number, 0 to 1",
        "evolution.poplation: unknown key; did you mean evolution.population?",
        "grippers.wide.opening: is missing; needed: a number, above 0, at most 10",
        "sed: unknown key; did you mean seed?",
        "shards: 0 is not allowed; allowed: a whole number, 1 to 1024",
        "space.cells: 0 is not allowed; allowed: a whole number, 1 to 26",
        "space: complexity_range must go from low to high, got 5.0 to 1.0",
        "targets.datasets: 'egad' is not defined; known: mine, two",
        f"targets.grippers: 'yumy' is not defined; known: {', '.join(sorted({*GRIPPERS, 'wide'}))}",
    ]
    assert len(found) == len(starts)
    for line, start in zip(sorted(found), starts, strict=True):
        assert line.startswith(start)


@pytest.mark.parametrize(
    ("config", "line"),
    [
        ({"seed": "3"}, 'seed: "3" is not allowed: that is text; in a file, write 3 without'),
        ({"seed": 3.0}, "seed: 3.0 is not allowed: write 3; allowed: a whole number"),
        ({"seed": True}, "seed: true is not allowed; allowed: a whole number"),
        ({"material": {"density": float("nan")}}, "material.density: NaN is not allowed"),
        ({"neat": 3}, "neat: 3 is not allowed; allowed: a section with the keys activations"),
        (
            {"datasets": {"mine": {"source": "primitives"}}},
            "datasets.mine: a dataset with source `primitives` needs `objects`",
        ),
        (
            {"datasets": {"mine": {"source": "evolved", "objects": 5}}},
            "datasets.mine: a dataset with source `evolved` takes no `objects`",
        ),
        ({"datasets": {}}, "datasets: {} is not allowed; allowed: a table with at least one name"),
        (
            {"targets": {"datasets": "egad"}},
            'targets.datasets: "egad" is not allowed; allowed: a l',
        ),
        ({"grippers": {"My Hand": {"opening": 1}}}, '"My Hand" cannot be a name; allowed: a name'),
        (
            {"grippers": {"a": {"opening": 0}}},
            "grippers.a.opening: 0 is not allowed; allowed: a number, above 0, at most 10 "
            "(widest opening, metres; with a file, by default that of the hand; with a cup, "
            "objects are scaled as for jaws of this opening (default 0.08))",
        ),
        ({"grippers": {"a": {"opening": 1, "palm": [1, 2]}}}, "grippers.a.palm.2: is missing"),
        ({"similarity": {"ranges": 100}}, "allowed: 16 or 32 or 64 or 128 or 256"),
        ({"grasps": 3}, "grasps: unknown key; did you mean evolution.grasps?"),
        ({"postprocess": {"max_candidate": 3}}, "did you mean postprocess.max_candidates?"),
        (
            {"qqqqzzz": 3},
            "qqqqzzz: unknown key; known: seed, shards, planning_time, keep_going, datasets",
        ),
        ({2: 3}, "2: unknown key"),
    ],
)
def test_a_sentence_says_what_is_wrong_and_what_is_allowed(config, line):
    assert line in "\n".join(problems(config))


@pytest.mark.parametrize(
    ("config", "line"),
    [
        ({"targets": {"datasets": ["other"]}}, "targets.datasets: 'other' is not defined"),
        ({"targets": {"grippers": ["other"]}}, "targets.grippers: 'other' is not defined"),
        (
            {"targets": {"failures": ["labels"]}},
            "targets.failures: with egad_75mm of targets.grippers, the detector labels knows where "
            "objects lie",
        ),
        (
            {"targets": {"failures": ["suction-depth"]}},
            "targets.failures: with egad_75mm of targets.grippers, the detector suction-depth is "
            "for suction cups; the gripper has jaws",
        ),
        (
            {"targets": {"detectors": ["vgn-evolved"]}},
            "targets.detectors: vgn-evolved asks for more than a view from above: see "
            "targets.clutter",
        ),
        (
            {"targets": {"failures": ["antipodal-cloud"]}, "failures": {"approach": "above"}},
            "targets.failures: antipodal-cloud asks for more than a view from above, and "
            "failures.approach is above",
        ),
        (
            {
                "datasets": {"shapes": {"source": "primitives", "objects": 9}},
                "targets": {"datasets": ["shapes"], "failures": ["random"]},
            },
            "targets.failures: shapes of targets.datasets has the source `primitives`, without",
        ),
        (
            {
                "detectors": {"mine": {"detector": "grasps:a.h5"}},
                "targets": {"grippers": ["cup_30mm"], "detectors": ["mine"], "failures": ["mine"]},
            },
            "targets.detectors: with cup_30mm of targets.grippers, the detector grasps:a.h5 is for "
            "jaws",
        ),
        ({"select_eval": {"gripper": "other"}}, "select_eval.gripper: 'other' is not defined"),
        ({"render": {"camera": "other"}}, "render.camera: 'other' is not defined"),
        ({"release": {"gripper": "other"}}, "release.gripper: 'other' is not defined"),
        (
            {"targets": {"grippers": ["cup_30mm"], "detectors": ["labels", "random"]}},
            "targets.detectors: with cup_30mm of targets.grippers, the detector random is for jaws",
        ),
        (
            {
                "grippers": {"mine": {"opening": 0.05, "sampler": "mine.py:sample"}},
                "targets": {"grippers": ["mine"], "render": True},
            },
            "targets.render: mine of targets.grippers has a sampler of its own; images need",
        ),
        (
            {"targets": {"grippers": ["cup_30mm"], "detectors": [], "render": True}},
            "targets.render: cup_30mm of targets.grippers has a suction cup; this is for jaws",
        ),
        (
            {"datasets": {name: {"source": "evolved"} for name in ("egad", "b")}},
            "datasets: at most one can have the source `evolved`, got egad, b",
        ),
    ],
)
def test_what_a_user_names_must_be_defined(config, line):
    assert line in "\n".join(problems(config))


MESHES = {"source": "meshes", "folder": "parts", "units": "mm"}


@pytest.mark.parametrize(
    "config",
    [
        {},
        {"datasets": {"parts": MESHES}, "targets": {"datasets": ["parts"]}},
        {"datasets": {"parts": MESHES}, "targets": {"datasets": []}},
        {
            "datasets": {"parts": MESHES},
            "targets": {"datasets": [], "grippers": ["mine"]},
            "grippers": {"mine": {"opening": 0.06}},
            "graspability": {"gripper": "mine"},
        },
        {"release": {"title": "Mine"}},
    ],
)
def test_defaults_may_name_what_a_user_left_out_also_when_all_settings_are_written_out(config):
    """A stage gets all settings; in those, every section is given."""
    settings = check(config)
    assert Settings.model_validate_json(settings.model_dump_json(), strict=True) == settings


def test_a_wrong_name_does_not_make_other_things_wrong():
    found = problems({"datasets": {"My Set": {"source": "meshes"}}})
    assert [line.split(":")[0] for line in found] == ["datasets.My Set", "datasets.My Set"]


@pytest.mark.parametrize("config", [5, ["seed"], "seed: 1", None])
def test_a_configuration_that_is_no_table(config):
    assert problems(config)[0].startswith("a configuration is a table of sections, not ")


def test_the_number_of_rounds_is_bounded_by_the_mistakes():
    """Every section wrong at once still ends, with a line for each."""
    wrong = {name: 3 for name in Settings.model_fields if name != "seed"} | {"seed": []}
    assert {line.split(":")[0] for line in problems(wrong)} == set(Settings.model_fields) - {
        *("shards", "planning_time")
    }


ENGINES_IN = ("trials", "clutter", "simulated_label")


def test_the_engine_is_the_same_on_every_python(monkeypatch):
    """Whatever is installed; else the same line would give two results."""
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert {getattr(Settings(), name).engine for name in ENGINES_IN} == {"mujoco"}


@pytest.mark.parametrize("section", ENGINES_IN)
def test_an_engine_that_is_not_installed_is_named(section, monkeypatch):
    found = importlib.util.find_spec
    chosen = check({section: {"engine": "pybullet"}})
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: None if name == "pybullet" else found(name)
    )
    with pytest.raises(UserError, match="pybullet is not installed"):
        check_engines(chosen)
    assert check_engines(check({})) == check({})
    searched = {"targets": {"failures": ["random"]}}
    with pytest.raises(UserError, match="pybullet is not installed"):
        check_engines(check(searched))
    alone = check({**searched, "failures": {"engines": ["mujoco"]}})
    assert check_engines(alone) == alone
