"""What is between rules and scripts: names are arguments, and what a job says and leaves."""

import json
import os
from collections import defaultdict
from importlib import import_module
from inspect import Parameter, signature
from pathlib import Path

import pandas as pd
import pytest
from forks import python
from pydantic import ValidationError
from script_jobs import job_of, run_as_job

from egad.evalset import EvalSelection
from egad.io import checksum
from egad.io.sums import read_sums
from egad.tables import parquet
from egad.tables.objects import REJECTED, rejection
from egad_workflow.job import arguments_of
from egad_workflow.provenance import settings_hash
from egad_workflow.settings import Settings, select

ROOT = Path(__file__).parents[2]
SETTINGS = select(Settings(seed=7), EvalSelection)
TABLE = SETTINGS.model_dump(mode="json")
LEFT_OUT = pd.DataFrame([rejection("a", "postprocess", "empty")])


def stage(
    settings: EvalSelection,
    parts: list[Path],
    base: Path | None,
    epoch: int,
    shard: tuple[int, int],
    out: Path,
    pictures: list[Path] | None = None,
    jobs: int = 1,
) -> None:
    """A function with a parameter of each kind."""


def test_names_in_a_rule_are_arguments_and_the_others_are_left_out():
    job = job_of(
        "stage",
        reads={"parts": ["a", "b"], "base": "c", "hand": "hand.urdf"},
        writes={"out": "d", "page": "e"},
        params={"settings": TABLE, "shard": [0, 2], "code": "0123"},
        wildcards={"epoch": "3", "dataset": "egad"},
        threads=2,
    )
    assert arguments_of(stage, job) == {
        "settings": TABLE,
        "parts": ["a", "b"],
        "base": "c",
        "epoch": "3",
        "shard": [0, 2],
        "out": "d",
        "jobs": 2,
    }


def test_params_come_before_wildcards():
    job = job_of("stage", params={"epoch": 5, "out": "x"}, wildcards={"epoch": "3", "out": "y"})
    found = arguments_of(stage, job)
    assert (found["epoch"], found["out"]) == (5, "x")


def test_a_file_or_none_is_one_and_a_list_stays_a_list():
    def files(**reads):
        found = arguments_of(stage, job_of("stage", reads=reads))
        return {name: found[name] for name in reads}

    assert files(base=[], parts=[], pictures=[]) == {"base": None, "parts": [], "pictures": []}
    one = files(base=["a"], parts=["a"], pictures=["a"])
    assert one == {"base": "a", "parts": ["a"], "pictures": ["a"]}
    assert files(parts="a", pictures="a") == {"parts": ["a"], "pictures": ["a"]}
    assert files(parts=["a", "b"], pictures=["a", "b"])["pictures"] == ["a", "b"]


@pytest.mark.parametrize(
    "named",
    [
        {"reads": {"base": "a"}, "writes": {"base": "b"}},
        {"reads": {"base": "a"}, "params": {"base": "b"}},
        {"writes": {"base": "a"}, "params": {"base": "b"}},
    ],
    ids="-".join,
)
def test_a_name_that_stands_for_two_things_is_an_error(named):
    with pytest.raises(TypeError, match="rule some has 'base' twice"):
        arguments_of(stage, job_of("some", **named))


def test_words_and_tables_become_what_the_function_names(tmp_path):
    got = []

    def take(
        settings: EvalSelection, parts: list[Path], epoch: int, shard: tuple[int, int]
    ) -> None:
        got.extend([settings, parts, epoch, shard])

    (tmp_path / "a").touch()
    run_as_job(
        take,
        "take",
        reads={"parts": [tmp_path / "a"]},
        params={"settings": TABLE, "shard": [1, 2]},
        wildcards={"epoch": "3"},
    )
    assert got == [SETTINGS, [tmp_path / "a"], 3, (1, 2)]
    assert isinstance(got[0], EvalSelection)


def test_what_a_rule_does_not_give_is_missed():
    with pytest.raises(ValidationError, match="Missing required argument"):
        run_as_job(stage, "stage", params={"settings": TABLE})


def test_text_that_is_returned_is_printed_and_numbers_are_not(capsys):
    def tell() -> str:
        return "2 objects"

    def count() -> list[float]:
        return [2.0]

    run_as_job(tell, "tell")
    assert capsys.readouterr().out == "2 objects\n"
    run_as_job(count, "count")
    assert capsys.readouterr().out == ""


def write(objects: list[Path], table: Path, page: Path, folder: Path) -> None:
    """Write a table, a file and a folder."""
    assert objects
    parquet.write(LEFT_OUT, REJECTED, table)
    page.write_text("page")
    folder.mkdir()
    (folder / "one.txt").write_text("one")


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A folder with what this function writes as a job."""
    monkeypatch.chdir(tmp_path)
    Path("objects.txt").write_text("objects")
    run_as_job(
        write,
        "write_all",
        reads={"objects": ["objects.txt"]},
        writes={"table": "table.parquet", "page": "page.html", "folder": "folder"},
        params={"settings": TABLE, "code": "0123"},
        wildcards={"dataset": "egad", "epoch": "3"},
    )
    return tmp_path


def test_a_table_says_what_it_comes_from(written):
    origin = parquet.origin_of(written / "table.parquet")
    assert (origin["stage"], origin["code"], origin["seed"]) == ("write_all", "0123", 7)
    assert origin["settings"] == settings_hash(SETTINGS)
    assert origin["arguments"] == {"dataset": "egad", "epoch": "3"}
    assert origin["inputs"] == [["objects.txt", checksum(written / "objects.txt")]]


def test_a_folder_that_a_param_names_has_one_list_of_sums(tmp_path):
    def fill(out: Path) -> None:
        out.mkdir()
        parquet.write(LEFT_OUT, REJECTED, out / "table.parquet")
        for name in ("a.txt", "b.txt"):
            (out / name).write_text(name)

    out = tmp_path / "out"
    writes = {"table": out / "table.parquet", "page": out / "a.txt"}
    run_as_job(fill, "fill", writes=writes, params={"out": str(out)})
    files = {"a.txt", "b.txt", "table.parquet"}
    assert {path.name for path in out.iterdir()} == files | {"SHA256SUMS"}
    listed, origin = read_sums(out / "SHA256SUMS")
    assert {path.name for path in listed} == files
    assert origin["stage"] == "fill"


SNAKEFILE = """
rule fine:
    input:
        words=["a.txt", "b.txt"],
        base=lambda wildcards: [],
    output:
        out="{name}.fine.txt",
    log:
        "logs/{name}.log",
    params:
        settings={"candidates": 5},
    threads: 2
    script:
        "fine.py"


rule wrong:
    output:
        out="{name}.wrong.txt",
    log:
        "logs/{name}.log",
    script:
        "wrong.py"
"""
FINE = """
import logging
import subprocess
from pathlib import Path

from pydantic import BaseModel

from egad_workflow.job import run_job

log = logging.getLogger(__name__)


class Counts(BaseModel):
    candidates: int


def run(
    settings: Counts, words: list[Path], base: Path | None, name: str, out: Path, jobs: int
) -> str:
    log.info("of the script")
    logging.getLogger("egad.sim").info("of the library")
    logging.getLogger("other").info("of another package")
    logging.getLogger("other").warning("warned by another package")
    subprocess.run(["echo", "of a child"], check=True)
    said = [path.read_text() for path in words]
    out.write_text(f"{name} {said} {base} {jobs} {settings.candidates}")
    return "returned"


if __name__ == "__main__":
    run_job(run)
"""
WRONG = """
from pathlib import Path

from egad.errors import UserError
from egad_workflow.job import run_job


def run(name: str, out: Path) -> None:
    out.write_text("half")
    if name == "defect":
        raise ValueError("a defect")
    raise UserError("a mistake")


if __name__ == "__main__":
    run_job(run)
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A folder in which Snakemake ran three jobs, of which two failed."""
    folder = tmp_path_factory.mktemp("workflow")
    files = {"Snakefile": SNAKEFILE, "fine.py": FINE, "wrong.py": WRONG, "a.txt": "a", "b.txt": "b"}
    for name, text in files.items():
        (folder / name).write_text(text)
    wanted = ["one.fine.txt", "mistake.wrong.txt", "defect.wrong.txt"]
    words = ["-m", "snakemake", "--cores", "2", "--keep-going", *wanted]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = python(words, folder=folder, environment=environment)
    assert done.returncode == 1, done.stderr
    return folder


def test_snakemake_runs_a_script_with_what_its_rule_names(ran):
    assert (ran / "one.fine.txt").read_text() == "one ['a', 'b'] None 2 5"
    listed, origin = read_sums(ran / "one.fine.txt.sha256")
    assert list(listed) == [ran / "one.fine.txt"]
    assert (origin["stage"], origin["arguments"]) == ("fine", {"name": "one"})
    assert [name for name, _ in origin["inputs"]] == ["a.txt", "b.txt"]


def test_all_that_a_job_says_is_in_its_log(ran):
    assert sorted((ran / "logs" / "one.log").read_text().splitlines()) == [
        "of a child",
        "of the library",
        "of the script",
        "returned",
        "warned by another package",
    ]


def test_the_log_of_a_failed_job_has_a_sentence_for_users_and_a_traceback_of_defects(ran):
    assert (ran / "logs" / "mistake.log").read_text() == "egad: a mistake\n"
    lines = (ran / "logs" / "defect.log").read_text().splitlines()
    assert lines[0].startswith("Traceback")
    assert lines[-1] == "ValueError: a defect"
    assert not list(ran.glob("*.wrong.txt*"))


LISTED = """
import json
from pathlib import Path


include: "workflow/Snakefile"


Path("rules.json").write_text(
    json.dumps(
        [
            {
                "rule": rule.name,
                "script": Path(rule.script).stem,
                "reads": list(rule.input.keys()),
                "writes": list(rule.output.keys()),
                "params": list(rule.params.keys()),
                "wildcards": list(rule.wildcard_names),
                "code": type(rule.params.get("code")).__name__,
            }
            for rule in workflow.rules
            if rule.script and rule.output  # `join` alone has none: others are made from it
        ]
    )
)
"""


@pytest.fixture
def rules(clean):
    """The rules that run scripts, and what they name."""
    (clean.folder / "listed.smk").write_text(LISTED)
    clean.make("--snakefile", "listed.smk", "--list-rules")
    return json.loads((clean.folder / "rules.json").read_text())


def test_every_rule_gives_its_script_what_it_asks_for(rules):
    """Whatever has no default; and by some rule of the script, what has one. And its version."""
    missing, unused = {}, defaultdict(list)
    for row in rules:
        rule, script = row.pop("rule"), row.pop("script")
        assert row.pop("code") in ("str", "function"), f"{rule}: `egad provenance` wants a text"
        named = {kind: dict.fromkeys(names, "word") for kind, names in row.items()}
        parameters = signature(run := import_module(script).run).parameters
        left = parameters.keys() - arguments_of(run, job_of(rule, **named))
        if needed := [name for name in left if parameters[name].default is Parameter.empty]:
            missing[rule] = sorted(needed)
        unused[script].append(left)
    assert missing == {}
    never = {script: sorted(set.intersection(*left)) for script, left in unused.items()}
    assert {script: names for script, names in never.items() if names} == {}
    scripts = {path.stem for path in (ROOT / "workflow" / "scripts").glob("*.py")}
    assert set(unused) == scripts
