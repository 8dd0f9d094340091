import os
import resource
import subprocess
import sys

import pytest

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


@pytest.fixture
def start(tmp_path):
    """Starts a program that uses the kernels, whose code is kept in a folder of its own."""
    (tmp_path / "ours.py").write_text(OURS)
    options = {"text": True, "env": os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}}
    options |= dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    return lambda code, **more: subprocess.Popen(
        [sys.executable, "-c", code, tmp_path], **options | more
    )


def finish(process):
    """What a program prints, and its messages."""
    output, messages = process.communicate()
    assert process.returncode == 0, messages
    return output, messages


def test_compilation_is_said_once_and_only_that_of_our_kernels(start):
    def said():
        output, messages = finish(start(PROGRAM))
        assert output.split() == ["2", "3.0", "3", "4.5"]
        return messages.splitlines()

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


def test_processes_of_a_command_compile_each_kernel_once_and_one_of_them_says_so(start):
    processes = [start(TOGETHER) for _ in range(4)]
    assert [each.stdout.readline() for each in processes] == ["ready\n"] * 4
    for each in processes:
        each.stdin.write("\n")
        each.stdin.flush()
    assert sum(int(each.stdout.readline()) for each in processes) == 3
    reports = [each.communicate("\n")[1] for each in processes]
    assert "".join(reports).count("compiling kernels") == 1
    later = TOGETHER.partition("print")[0]
    for call, new_command in (("triple(1.5)", False), ("triple(1j)", True)):
        _, messages = finish(start(later + call, start_new_session=new_command))
        assert ("compiling kernels" in messages) == new_command


TIMES = """
import logging, sys
import egad

egad.__path__.append(sys.argv[1])
from egad.ours import double

print(double(2), double(1.5), sum(double.stats.cache_hits.values()))
"""


def test_damaged_code_is_compiled_again(start, tmp_path):
    assert finish(start(TIMES))[0] == "4 3.0 0\n"
    assert finish(start(TIMES))[0] == "4 3.0 2\n"
    for ending in (".nbi", ".nbc"):
        files = sorted((tmp_path / "cache").rglob(f"*{ending}"))
        whole = {path: path.read_bytes() for path in files}
        assert whole
        for end in (0, -20, None):  # None: other bytes in the middle
            for path, data in whole.items():
                middle = len(data) // 2
                path.write_bytes(
                    data[:end]
                    if end is not None
                    else data.replace(data[middle : middle + 8], b"spamspam")
                )
            assert finish(start(TIMES))[0].startswith("4 3.0 ")
    assert finish(start(TIMES))[0] == "4 3.0 2\n"


def test_code_that_cannot_be_kept_is_said_once_with_the_folder(start, tmp_path):
    limits = (resource.RLIMIT_FSIZE, (100, 100))  # bytes of a file, as on a full disk
    output, messages = finish(start(TIMES, preexec_fn=lambda: resource.setrlimit(*limits)))
    assert output == "4 3.0 0\n"
    warnings = [line for line in messages.splitlines() if "cannot be kept" in line]
    assert len(warnings) == 1
    assert "cache/kernels-" in warnings[0]
    assert not list((tmp_path / "cache").rglob("*.nbc"))
