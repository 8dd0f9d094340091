"""What a dry run says of results whose settings have changed, in real runs of Snakemake."""

import os
import re
import sys
from logging import Handler, LogRecord
from pathlib import Path
from types import SimpleNamespace

import pytest
from forks import python

from egad_workflow.display.messages import LOGGER
from egad_workflow.display.reasons import changes, explain_reasons

SNAKEFILE = """
from egad_workflow.display import explain_reasons

explain_reasons(workflow)


rule work:
    output:
        "{gripper}.done",
    params:
        settings={
            "trials": {"attempts": int(config["attempts"]), "depths": [1.5, None]},
            "gripper": {"force": config["force"]},
        },
        code=config["code"],
    message:
        "Working"
    shell:
        "touch {output}"
"""


@pytest.mark.parametrize(
    ("attempts", "force", "code", "reason"),
    [
        (40, 70, "a" * 16, None),
        (
            *(60, 55, "b" * 16),
            "grippers.panda.force 70 -> 55, trials.attempts 40 -> 60, the code of this stage",
        ),
    ],
)
def test_a_dry_run_names_what_has_changed(tmp_path, attempts, force, code, reason):
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    root = str(Path(__file__).parents[3])
    environment = os.environ | {"PYTHONPATH": root, "PATH": f"{Path(sys.executable).parent}:/bin"}

    def said(attempts, force, code, *options):
        config = [f"attempts={attempts}", f"force={force}", f"code={code}"]
        words = ["-m", "snakemake", "--cores", "1", "panda.done", *options, "--config", *config]
        done = python(words, folder=tmp_path, environment=environment)
        assert done.returncode == 0, done.stderr
        return done.stdout + done.stderr

    said(40, 70, "a" * 16)
    dry = said(attempts, force, code, "--dry-run")
    reasons = re.findall(r"Reason: Changed since last execution: (.*)", dry)
    assert reasons == ([reason] if reason else [])
    assert "Params have changed" not in dry


def test_few_of_many_changes_are_named():
    before, now = ({f"number_{each}": value for each in range(10)} for value in (1, 2))
    text = changes({repr(before)}, {"settings": now})
    assert text.startswith("number_0 1 -> 2, number_1 1 -> 2, ")
    assert text.endswith(", and 4 more")
    assert text.count("->") == 6


@pytest.mark.parametrize(
    ("before", "now", "expected"),
    [
        ({"3"}, {"shards": 4}, "shards 3 -> 4"),
        ({"{'a': 1}"}, {"settings": {"b": 1}}, "a 1 -> None, b None -> 1"),
        ({"[1, 2]", "[3]"}, {"measures": [4]}, "measures"),
        ({"['0123456789abcdef']"}, {"sampler": ["fedcba9876543210"]}, "sampler"),
        ({"<object at 0x7f>", "inf"}, {"limit": 2}, "limit"),
        ({"'x'"}, {}, "parameters that are no longer there"),
    ],
)
def test_params_are_paired_as_far_as_that_is_certain(before, now, expected):
    assert changes(before, now) == expected


@pytest.mark.parametrize(
    "workflow", [SimpleNamespace(), SimpleNamespace(dag=SimpleNamespace(jobs=[]))]
)
def test_a_reason_that_is_not_understood_stays_as_it_is(workflow, monkeypatch):
    handler, record = Handler(), LogRecord("snakemake", 20, "", 0, "", (), None)
    monkeypatch.setattr(LOGGER, "handlers", [handler])
    explain_reasons(workflow)
    assert handler.filter(record)
    record.reason, record.jobid = "Params have changed since last execution: 3", 1
    assert handler.filter(record)
    assert record.reason == "Params have changed since last execution: 3"
