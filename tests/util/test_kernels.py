import os
import subprocess
import sys

OURS = """
from egad._util.kernels import kernel

@kernel()
def double(x):
    return 2 * x

@kernel()
def triple(x):
    return 3 * x
"""
PROGRAM = """
import sys
import egad
import numba

egad.__path__.append(sys.argv[1])
from egad.ours import double, triple

@numba.njit
def of_others(x):
    return x + 1

of_others(1)
print("others are done", file=sys.stderr)
print(double(1), double(1.5), triple(1), triple(1.5))
"""


def test_compilation_is_said_once_and_only_that_of_our_kernels(tmp_path):
    (tmp_path / "ours.py").write_text(OURS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def said():
        run = subprocess.run(
            [sys.executable, "-c", PROGRAM, tmp_path],
            capture_output=True,
            text=True,
            check=True,
            env=environment,
        )
        assert run.stdout.split() == ["2", "3.0", "3", "4.5"]
        return run.stderr.splitlines()

    first, *ours = said()
    assert first == "others are done"
    assert set(ours) == {"compiling kernels, at their first use only ..."}  # again after a while
    assert said() == ["others are done"]  # they are kept
