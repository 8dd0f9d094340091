"""The commands of the documentation exist, and Snakemake understands them as they are meant."""

import re
import shlex
from pathlib import Path

import pytest
import yaml
from snakemake.cli import get_argument_parser

ROOT = Path(__file__).parents[2]
PAGES = [
    path
    for folder in (ROOT, ROOT / "config", ROOT / "docs", ROOT / "studies")
    for pattern in ("*.md", "*/*.md", "*.yaml", "*/*.yaml")
    for path in folder.glob(pattern)
]


def commands(text):
    """The commands that name a configuration, continued lines joined."""
    joined = re.sub(r" *\\\n[# ]*", " ", text)
    return re.findall(r"\bsnakemake -[^`#\n]*--configfile [^`#\n]+", joined)


def profile_executor(profile):
    """The executor that a profile names."""
    return yaml.safe_load((ROOT / "profiles" / profile / "config.yaml").read_text())["executor"]


COMMANDS = dict.fromkeys(command for path in PAGES for command in commands(path.read_text()))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_target_is_not_taken_for_a_configuration(command):
    """`--configfile` takes all words that follow, so `--` must end them."""
    given = get_argument_parser().parse_args(shlex.split(command)[1:])
    assert not [path for path in given.configfile if path.parts[0] in {"results", "release"}]


EXECUTORS = {
    (str(path.relative_to(ROOT)), executor or profile_executor(profile))
    for path in PAGES
    for profile, executor in re.findall(
        r"\bsnakemake [^`\n]*?--(?:profile profiles/([\w-]+)|executor ([\w-]+))", path.read_text()
    )
}


@pytest.mark.parametrize(("page", "executor"), sorted(EXECUTORS))
def test_the_plugin_of_an_executor_is_installed_by_setup_or_named_on_the_page(page, executor):
    plugin = f"snakemake-executor-plugin-{executor}"
    locked = f"\n{plugin}==" in (ROOT / "requirements.lock").read_text()
    assert locked or plugin in (ROOT / page).read_text()


PROGRAMS = {
    name
    for path in PAGES
    for name in re.findall(
        r"\bpython\s+((?:docs/scripts|studies|tests/benchmarks)/[\w/]+\.py)", path.read_text()
    )
}


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_a_named_program_exists(name):
    assert (ROOT / name).is_file()
