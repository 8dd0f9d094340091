"""The display in a real run of Snakemake: two jobs at once in a pipe, one of which fails."""

import os
import re
import sys
from pathlib import Path

from forks import python

SNAKEFILE = """
import os

from egad._util.progress import MARKS, Pace
from egad_workflow.display import lines, start_display

os.environ[MARKS] = "1"  # as the Snakefile of the workflow does
lines.PEOPLE = Pace(0.2, 0.2, 0)
lines.TICK = 0.1


onstart:
    start_display(len(workflow.dag))


rule all:
    input:
        "good",
        "bad",


rule work:
    output:
        made="{name}",
    log:
        "{name}.log",
    message:
        "Working on {wildcards.name}"
    script:
        "work.py"
"""
WORK = """
import time
from pathlib import Path

from egad._util.progress import progress
from egad.errors import UserError
from egad_workflow.job import run_job


def run(name: str, made: Path) -> None:
    for number in progress(range(4), "steps", 4, scale=5):
        if number == 2 and name == "bad":
            raise UserError("the mesh is bad")
        time.sleep(0.7)
    made.touch()


if __name__ == "__main__":
    run_job(run)
"""


def test_two_jobs_in_a_pipe_are_told_of_and_why_one_of_them_failed(tmp_path):
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    (tmp_path / "work.py").write_text(WORK)
    root = Path(__file__).parents[3]
    paths = {
        "PYTHONPATH": str(root),
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }
    words = ["-m", "snakemake", "--cores", "2", "--show-failed-logs"]
    done = python(words, folder=tmp_path, environment=os.environ | paths)
    assert done.returncode == 1
    for name in ("good", "bad"):
        assert f"start work: Working on {name}" in done.stderr
        assert re.search(rf"Working on {name}: steps: \d+/20", done.stderr)
    assert "done  work: Working on good" in done.stderr
    assert "(1 of 3 steps)" in done.stderr
    assert "Error in rule work: Working on bad" in done.stderr
    assert done.stderr.count("egad: the mesh is bad") == 1
    (kept,) = (tmp_path / ".snakemake" / "log").iterdir()
    assert "egad: the mesh is bad" in kept.read_text()
