import resource
import subprocess
import sys

import pytest
import trimesh

from egad._util.memory import LIMITS, is_out_of_memory, memory_limit

MIB = 1 << 20
READS = """
import sys
from pathlib import Path
from egad._util.program import readable_errors

with readable_errors():
    from egad.io import read_mesh

    print(len(read_mesh(Path(sys.argv[1]), "mm").faces))
"""


def run_under(kind, soft, hard, *command):
    """Run Python under a limit on memory."""
    return subprocess.run(
        [sys.executable, "-c", *command],
        preexec_fn=lambda: resource.setrlimit(kind, (soft, hard)),
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
    ("kind", "soft", "hard"),
    [
        (resource.RLIMIT_AS, 3_800 * MIB, 3_800 * MIB),
        (resource.RLIMIT_AS, 1_500 * MIB, resource.RLIM_INFINITY),
        (resource.RLIMIT_DATA, 800 * MIB, 800 * MIB),
    ],
)
def test_a_file_is_read_under_a_limit_below_that_of_its_reader(ball, kind, soft, hard):
    assert run_under(kind, soft, hard, READS, ball).stdout == "80\n"


@pytest.mark.parametrize(("kind", "option"), [(kind, LIMITS[kind][0]) for kind in LIMITS])
@pytest.mark.parametrize("mib", [100, 500])
def test_too_low_a_limit_is_a_sentence_before_libraries_crash(ball, kind, option, mib):
    run = run_under(kind, mib * MIB, mib * MIB, READS, ball)
    assert run.returncode == 1
    assert run.stderr.startswith("egad: out of memory: ")
    assert f"the limit is {mib} MB (ulimit -{option} {mib << 10};" in run.stderr
    assert len(run.stderr.splitlines()) == 1


BLAMES = """
import numpy as np
from pathlib import Path
from egad._util.limited import limited
from egad._util.program import readable_errors
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
    run = run_under(resource.RLIMIT_AS, 2_000 * MIB, 2_000 * MIB, BLAMES, ball)
    lines = run.stdout.splitlines()
    assert len(lines) == 2, run.stderr
    assert lines[0].startswith("egad: out of memory; the limit is 2,000 MB (ulimit -v 2048000;")
    assert "ended with status -6, probably out of memory; the limit is 2,000 MB" in lines[1]


def test_what_says_that_memory_ran_out():
    assert is_out_of_memory(MemoryError())
    assert is_out_of_memory(OSError(12, "Cannot allocate memory"))
    assert is_out_of_memory(RuntimeError("can't start new thread"))
    assert not is_out_of_memory(OSError(28, "No space left on device"))
    assert not is_out_of_memory(RuntimeError("no"))


def test_without_a_limit_there_is_none():
    if all(resource.getrlimit(kind)[0] == resource.RLIM_INFINITY for kind in LIMITS):
        assert memory_limit() is None
