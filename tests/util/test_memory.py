import resource
import subprocess
import sys

import pytest
import trimesh

from egad._util.memory import is_out_of_memory

MIB = 1 << 20
READS = """
import sys
from pathlib import Path
from egad_workflow.program import readable_errors

with readable_errors():
    from egad.io import read_mesh

    print(len(read_mesh(Path(sys.argv[1]), "mm").faces))
"""


def run_under(soft, hard, *command):
    """Run Python under a limit on addresses."""
    return subprocess.run(
        [sys.executable, "-c", *command],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (soft, hard)),
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    path = tmp_path_factory.mktemp("meshes") / "ball.ply"
    trimesh.creation.icosphere(subdivisions=1).export(path)
    return path


@pytest.mark.parametrize(
    ("soft", "hard"), [(3_800 * MIB, 3_800 * MIB), (1_500 * MIB, resource.RLIM_INFINITY)]
)
def test_a_file_is_read_under_a_limit_below_that_of_its_reader(ball, soft, hard):
    assert run_under(soft, hard, READS, ball).stdout == "80\n"


@pytest.mark.parametrize("mib", [100, 500])
def test_too_low_a_limit_is_a_sentence_before_libraries_crash(ball, mib):
    run = run_under(mib * MIB, mib * MIB, READS, ball)
    assert run.returncode == 1
    assert run.stderr.startswith("egad: out of memory (1,335 MB are needed at least); ")
    assert f"the limit is {mib} MB (ulimit -v {mib << 10};" in run.stderr
    assert len(run.stderr.splitlines()) == 1


BLAMES = """
import numpy as np
from pathlib import Path
from egad._util.limited import limited
from egad_workflow.program import readable_errors
from egad.io import mesh
from egad.tables import parquet, untrusted
from egad.tables.evaluation import EVAL49

def fill(path):
    np.ones(1 << 30)

def die(path):
    import os
    os.abort()

for function in (fill, die):
    mesh.parse_file = function
    try:
        with readable_errors():
            mesh.read_mesh(Path(__import__("sys").argv[1]), "mm")
    except SystemExit as error:
        print(error)
"""


def test_a_file_that_the_limit_is_too_low_for_is_not_called_damaged(ball):
    run = run_under(2_000 * MIB, 2_000 * MIB, BLAMES, ball)
    lines = run.stdout.splitlines()
    assert len(lines) == 2, run.stderr
    assert lines[0].startswith("egad: out of memory; the limit is 2,000 MB (ulimit -v 2048000;")
    assert "ended with status -6, perhaps out of memory; the limit is 2,000 MB" in lines[1]


def test_what_says_that_memory_ran_out():
    assert is_out_of_memory(MemoryError())
    assert is_out_of_memory(OSError(12, "Cannot allocate memory"))
    assert is_out_of_memory(RuntimeError("can't start new thread"))
    assert not is_out_of_memory(OSError(28, "No space left on device"))
    assert not is_out_of_memory(RuntimeError("no"))


@pytest.mark.parametrize(
    ("limit", "said"), [(resource.RLIM_INFINITY, "None"), (1 << 30, str(1 << 30))]
)
def test_the_limit_is_that_of_the_process(limit, said):
    program = "from egad._util.memory import memory_limit; print(memory_limit())"
    assert run_under(limit, resource.RLIM_INFINITY, program).stdout == f"{said}\n"


CRASHES = """
import contextlib
import os
from pathlib import Path
from egad_workflow.restarting_worker import RestartingWorker

@contextlib.contextmanager
def work():
    yield lambda number: number or os.abort()

with RestartingWorker(work) as worker:
    print(worker(0), worker(2))
"""


def test_a_crash_under_a_limit_does_not_end_a_run():
    run = run_under(2_500 * MIB, 2_500 * MIB, CRASHES)
    assert run.stdout == "None 2\n", run.stderr
    assert run.stderr.count("ended with status -6, perhaps out of memory; the limit is 2,500") == 2
