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
    assert ours == ["compiling kernels, which happens once and takes about half a minute ..."]
    assert said() == ["others are done"]  # they are kept


TOGETHER = """
import os
import sys
import egad

egad.__path__.append(sys.argv[1])
from egad.ours import double, triple

print("ready", flush=True)
sys.stdin.readline()
assert [double(1), double(1.5), triple(1)] == [2, 3.0, 3]
print(sum(sum(each.stats.cache_misses.values()) for each in (double, triple)), flush=True)
sys.stdin.readline()
"""


def test_processes_of_a_command_compile_each_kernel_once_and_one_of_them_says_so(tmp_path):
    (tmp_path / "ours.py").write_text(OURS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", TOGETHER, tmp_path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        for _ in range(4)
    ]
    assert [each.stdout.readline() for each in processes] == ["ready\n"] * 4
    for each in processes:
        each.stdin.write("\n")
        each.stdin.flush()
    assert sum(int(each.stdout.readline()) for each in processes) == 3
    reports = [each.communicate("\n")[1] for each in processes]
    assert "".join(reports).count("compiling kernels") == 1
    later = TOGETHER.partition("print")[0]
    for call, new_command in (("triple(1.5)", False), ("triple(1j)", True)):
        run = subprocess.run(
            [sys.executable, "-c", later + call, tmp_path],
            capture_output=True,
            check=True,
            env=environment,
            start_new_session=new_command,
        )
        assert (b"compiling kernels" in run.stderr) == new_command
