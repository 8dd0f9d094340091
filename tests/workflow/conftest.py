"""A copy of the workflow in a folder of its own, and a finished run of it that tests share."""

import fcntl
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml
from forks import Forked

ROOT = Path(__file__).parents[2]
SOURCES = ["Snakefile", "config", "envs", "profiles", "workflow"]
TEST_CONFIG = "config/test.yaml"
# The message of a job has what it is given, where a person reads what it does.
TOLD = """
include: "workflow/Snakefile"


for each in workflow.rules:
    names = [name for name, _ in each.params.items()]
    each.message = "\\t".join(["TOLD {rule}", "{output}", *[f"{n}={{params.{n}}}" for n in names]])
"""
HUNGRY = """
include: "workflow/rules/resources.smk"


rule all:
    input:
        expand("{{guest}}.fed", guest={guests}),


rule hungry:
    output:
        "{{guest}}.fed",
    resources:
        **needs(*{needs}),
    shell:
        {command!r}
"""


class Job(NamedTuple):
    """A job that Snakemake would start."""

    rule: str
    output: str
    params: dict[str, str]


@dataclass(frozen=True)
class Checkout:
    """A folder with the sources of the workflow."""

    folder: Path

    def start(self, *arguments, configs=(TEST_CONFIG,)):
        """Start Snakemake in a process group of its own."""
        return subprocess.Popen(
            [sys.executable, "-m", "snakemake", *_words(arguments, configs)],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def snakemake(self, *arguments, configs=(TEST_CONFIG,), **variables):
        """Run Snakemake to its end: its exit status and what it said."""
        words = ["-m", "snakemake", *_words(arguments, configs)]
        with tempfile.NamedTemporaryFile("r", encoding="utf-8") as said:
            with Path(said.name).open("ab") as file:
                run = Forked(
                    words,
                    folder=self.folder,
                    environment=self.environment | variables,
                    files={1: file.fileno(), 2: file.fileno()},
                    own_session=True,
                )
            try:
                return run.wait(), said.read()
            except BaseException:  # given up: it is killed with all its jobs
                os.killpg(run.pid, signal.SIGKILL)
                raise

    def make(self, *arguments, configs=(TEST_CONFIG,), **variables):
        """Run Snakemake, with some more variables, and fail with what it said if it fails."""
        status, said = self.snakemake(*arguments, configs=configs, **variables)
        assert status == 0, said
        return said

    def planned(self, *arguments, configs=(TEST_CONFIG,)):
        """How many jobs of each rule a run would start."""
        return self.jobs(self.make("--dry-run", "--cores", 2, *arguments, configs=configs))

    def told(self, *arguments, snakefile="workflow/Snakefile", configs=(TEST_CONFIG,)):
        """The jobs that a run would start: the rule of each, its output, its params as texts."""
        (self.folder / "told.smk").write_text(TOLD.replace("workflow/Snakefile", snakefile))
        said = self.make("--dry-run", "--snakefile", "told.smk", *arguments, configs=configs)
        rows = [row.split("\t") for row in re.findall(r"TOLD (.*)", said)]
        return [
            Job(rule, output, dict(each.split("=", 1) for each in params))
            for rule, output, *params in rows
        ]

    @staticmethod
    def jobs(text):
        """The same, from what a dry run said."""
        table = text.partition("Job stats:")[2].partition("total ")[0]
        rows = re.findall(r"^(\w+) +(\d+)$", table, flags=re.MULTILINE)
        found = {rule: int(count) for rule, count in rows}
        assert bool(found) != ("Nothing to be done" in text), text
        return found

    def overlay(self, name, settings):
        """A configuration file to lay over the others."""
        return written(self.folder / name, settings)

    def feed(self, *arguments, needs, command, guests=("one",)):
        """Run a workflow of one rule, `hungry`, that needs much; a job for each guest."""
        (self.folder / "hungry.smk").write_text(
            HUNGRY.format(needs=needs, guests=list(guests), command=command)
        )
        return self.make(*arguments, "--snakefile", "hungry.smk", configs=())

    def bytes(self):
        """The contents of all results by path."""
        results = self.folder / "results"
        files = (path for path in results.rglob("*") if path.is_file())
        return {
            str(path.relative_to(results)): path.read_bytes()
            for path in files
            if path.name != ".snakemake_timestamp"
        }

    @property
    def results(self):
        return self.folder / "results"

    @property
    def environment(self):
        """Where the library is: that of this repository, whose compiled kernels are kept."""
        kept = {key: value for key, value in os.environ.items() if not key.startswith("SNAKEMAKE")}
        own = (self.folder / "egad").is_dir()
        return kept | {"PYTHONPATH": str(self.folder if own else ROOT)}

    def take_library(self):
        """Copy the library into the folder, to edit it."""
        uncompiled = shutil.ignore_patterns("__pycache__")
        for name in ("egad", "egad_workflow"):
            shutil.copytree(ROOT / name, self.folder / name, ignore=uncompiled)


def _words(arguments, configs):
    return [*map(str, arguments), *(["--configfile", *map(str, configs)] if configs else [])]


def written(path, settings):
    """A configuration file with some settings."""
    path.write_text(yaml.safe_dump(settings))
    return path


def checkout(folder):
    """Copy the sources."""
    folder.mkdir()
    for name in SOURCES:
        source = ROOT / name
        copy = shutil.copytree if source.is_dir() else shutil.copy2
        copy(source, folder / name)
    return Checkout(folder)


@pytest.fixture(scope="session")
def kept(tmp_path_factory):
    """Makes clean checkouts by name that several tests share."""
    return lambda name: checkout(tmp_path_factory.mktemp(name) / "clean")


@pytest.fixture
def another(tmp_path):
    """Makes clean checkouts by name."""
    return lambda name: checkout(tmp_path / name)


@pytest.fixture
def empty(tmp_path):
    """A folder without anything."""
    return Checkout(tmp_path)


@pytest.fixture
def clean(another):
    """A clean checkout."""
    return another("clean")


@pytest.fixture(scope="session")
def finished(tmp_path_factory, worker_id):
    """A finished run on two cores, one for all processes of the tests. Tests must not change it."""
    own = tmp_path_factory.getbasetemp()
    shared = own if worker_id == "master" else own.parent
    done = shared / "finished.done"
    with (shared / "finished.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if done.exists():
            return Checkout(shared / "finished")
        shutil.rmtree(shared / "finished", ignore_errors=True)
        made = checkout(shared / "finished")
        made.make("--cores", 2, NUMBA_DEBUG_CACHE="1")
        done.touch()
    return made


@pytest.fixture
def planned(finished, tmp_path):
    """How many jobs of each rule the finished run would start with other settings."""

    def _planned(*targets, **settings):
        other = written(tmp_path / "other.yaml", settings)
        return finished.planned(*targets, configs=[TEST_CONFIG, other])

    return _planned


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the finished run, to change."""
    shutil.copytree(finished.folder, tmp_path / "copy")
    return Checkout(tmp_path / "copy")
