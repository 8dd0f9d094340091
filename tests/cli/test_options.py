"""What all commands have in common: groups, names of options, completion in shells."""

import inspect
import os
import subprocess
import sys
from pathlib import Path
from typing import get_type_hints

import pandas as pd
import pytest
import trimesh
from commands import egad
from typer.models import OptionInfo

from egad import __version__
from egad.cli import gripper, trials
from egad.cli.commands import app
from egad.cli.gripper import _name_of

FUNCTIONS = [
    each.callback
    for program in (app, gripper.gripper, trials.trials)
    for each in program.registered_commands
]


def options():
    """Every option of every command: the function, its default, its type and its description."""
    for function in FUNCTIONS:
        defaults = inspect.signature(function).parameters
        for name, hint in get_type_hints(function, include_extras=True).items():
            for each in getattr(hint, "__metadata__", ()):
                if isinstance(each, OptionInfo):
                    yield function, defaults[name].default, hint.__origin__, each


def names(option):
    """Those that its declaration has; typer takes the first for a default until it is used."""
    return [each for each in (option.default, *option.param_decls) if isinstance(each, str)]


def options_called(name):
    return [each for each in options() if name in names(each[-1])]


def test_help_has_four_groups_in_their_order():
    titles = ["Objects", "Grasps and grippers", "Detectors", "Files and runs"]
    lines = egad("--help").stdout.splitlines()
    shown = [line.strip("╭─╮ ") for line in lines if line.startswith("╭")]
    assert shown == ["Options", *titles]


def test_each_command_is_where_ls_shows_it():
    kin = {"film": "replay", "inspect": "gripper"}
    kin |= dict.fromkeys(("verify", "check_config"), "provenance")
    kin |= dict.fromkeys(("compare", "report", "template"), "trials")
    for function in FUNCTIONS:
        name = function.__name__
        assert function.__module__ == f"egad.cli.{kin.get(name, name)}"


@pytest.mark.parametrize("name", ["--units", "--config", "--jobs"])
def test_an_option_means_the_same_everywhere(name):
    found = options_called(name)
    assert len({(kind, str(default), each.help) for _, default, kind, each in found}) == 1


def test_options_of_several_commands_are_declared_with_their_names():
    shared = {"units", "config", "jobs", "gripper", "rule", "out"}
    for function in FUNCTIONS:
        hints = get_type_hints(function, include_extras=True)
        for name in shared & hints.keys():
            (each,) = hints[name].__metadata__
            assert names(each)[0] == f"--{name}", function


def test_what_is_written_is_named_by_the_same_letter():
    written = [names(each) for *_, each in options_called("--out")]
    assert written == [names(each) for *_, each in options_called("-o")]
    assert all(each == ["--out", "-o"] for each in written)


def test_gripper_and_rule_say_what_they_are_without_the_option():
    for name, start in {"--gripper": "gripper of the conf", "--rule": "scaling to the g"}.items():
        for function, default, _, each in options_called(name):
            assert each.help.startswith(start), function
            assert default or "; default: " in each.help, function
    assert len({kind for _, default, kind, _ in options_called("--rule") if default is None}) == 1


def test_a_gripper_is_a_name_or_an_opening(tmp_path):
    trimesh.creation.box((0.03, 0.04, 0.05)).export(tmp_path / "box.ply")
    (tmp_path / "hand.yaml").write_text("grippers: {mine: {opening: 0.06}}")
    given = ["measure", tmp_path / "box.ply", "--units", "m", "--jobs", 1, "--max-candidates", 200]
    tables, printed = [], []
    for words in (["0.06"], ["mine", "--config", tmp_path / "hand.yaml"], ["yumi"]):
        done = egad(*given, "-o", tmp_path / "table.csv", "--gripper", *words)
        assert done.returncode == 0, done.stderr
        tables.append(pd.read_csv(tmp_path / "table.csv"))
        printed.append(done.stdout)
    assert tables[0].equals(tables[1])
    assert tables[0]["opening"].tolist() == [0.06]
    assert "they are for the rule exact and 0.06 m" in printed[0]
    assert tables[2]["opening"].tolist() == [0.05]


def test_rescale_takes_gripper_and_rule_from_a_configuration(tmp_path):
    trimesh.creation.box((0.03, 0.04, 0.05)).export(tmp_path / "box.ply")
    text = "grippers: {mine: {opening: 0.06}}\nrescale: {rule: exact}\n"
    (tmp_path / "mine.yaml").write_text(text)
    given = [tmp_path / "box.ply", "--units", "m", "--config", tmp_path / "mine.yaml", "--jobs", 1]
    for words, name in {
        ("--gripper", "mine"): "box_exact_60mm.obj",
        ("--gripper", "mine", "--rule", "none"): "box_none_60mm.obj",
        ("--gripper", "0.07"): "box_exact_70mm.obj",
    }.items():
        done = egad("rescale", *given, *words, "--out", tmp_path / "out")
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "out" / name).is_file()


def test_an_error_of_a_setting_names_the_option(tmp_path):
    done = egad("train", tmp_path, "--out", tmp_path / "new", "--seed", 2**32)
    assert done.returncode == 1
    assert done.stderr.startswith("egad: --seed: seed: 4294967296 is not allowed")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("egad mea", ["measure"]),
        ("egad benchmark mine.py --rule ", ["paper", "egad-script", "exact", "none"]),
    ],
)
def test_a_shell_completes_commands_options_and_values(words, expected):
    code = (
        "import sys\n"
        "from egad.cli import main\n"
        "sys.argv = ['egad']\n"
        "try:\n    main()\n"
        "finally:\n    assert not {'numpy', 'numba', 'pandas', 'trimesh'} & set(sys.modules)\n"
    )
    asked = {
        "_EGAD_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split(" ")) - 1),
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | asked,
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    assert done.stdout.split() == expected


def test_the_completion_of_a_shell_is_printed(monkeypatch):
    monkeypatch.setenv("_EGAD_COMPLETE", "source_bash")
    assert "complete -o default -F _egad_completion egad" in egad().stdout


def test_the_package_is_a_program_too():
    root = Path(__file__).parents[2]
    command = [sys.executable, "-m", "egad", "--version"]
    done = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True)
    assert done.stdout.strip() == f"egad {__version__}"


@pytest.mark.parametrize(
    ("taken", "name"),
    [((), "my_panda"), (("my_panda",), "my_panda_2"), (("my_panda", "my_panda_2"), "my_panda_3")],
)
def test_no_other_gripper_has_the_name_of_a_hand_that_is_inspected(taken, name):
    assert _name_of(Path("Panda.urdf"), taken) == name
