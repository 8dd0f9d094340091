"""The commands of the documentation exist, and Snakemake understands them as they are meant."""

import re
import shlex
from pathlib import Path

import pytest
from snakemake.cli import get_argument_parser

ROOT = Path(__file__).parents[2]
PAGES = [
    path
    for folder in (ROOT, ROOT / "config", ROOT / "docs", ROOT / "experiments")
    for pattern in ("*.md", "*/*.md", "*.yaml", "*/*.yaml")
    for path in folder.glob(pattern)
]


def commands(text):
    """The commands that name a configuration, continued lines joined."""
    joined = re.sub(r" *\\\n[# ]*", " ", text)
    return re.findall(r"\bsnakemake -[^`#\n]*--configfile [^`#\n]+", joined)


COMMANDS = dict.fromkeys(command for path in PAGES for command in commands(path.read_text()))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_target_is_not_taken_for_a_configuration(command):
    """`--configfile` takes all words that follow, so `--` must end them."""
    given = get_argument_parser().parse_args(shlex.split(command)[1:])
    assert not [path for path in given.configfile if path.parts[0] in {"results", "release"}]


PROGRAMS = {
    name
    for path in PAGES
    for name in re.findall(
        r"\bpython\s+((?:experiments|tests/benchmarks)/[\w/]+\.py)", path.read_text()
    )
}


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_a_named_program_exists(name):
    assert (ROOT / name).is_file()
