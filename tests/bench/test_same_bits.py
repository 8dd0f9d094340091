"""Models and simulations have the same bits with every kernel of BLAS, NumPy and the C library."""

import os
import platform
import subprocess
import sys

import pytest

KINDS = {
    "this processor": {},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "Prescott": {"OPENBLAS_CORETYPE": "Prescott"},
    "C library without AVX": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F"},
    "NumPy without AVX": {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"},
}
PROGRAM = """
import hashlib, sys, egad
from egad._util.arithmetic import arithmetic
objects = egad.load("evaluation-set").select(["C1", "E4"])
digest = hashlib.sha256()
trials = egad.run_trials("random", objects, "egad_75mm", 4, errors="typical", engine="mujoco")
scenes = {"scenes": ["packed"], "rounds": 2, "noise": ["none"]}
cleared = egad.run_benchmark("random", objects, "panda", **scenes)
for table in (trials.table, cleared.table):
    digest.update(table.drop(columns="platform").to_csv().encode())
print(digest.hexdigest(), len(trials), trials.table["platform"][0], arithmetic(), sep="|")
"""


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the kernels are those of x86-64")
def test_attempts_have_the_same_bits_with_all_kernels():
    found = {}
    for kind, variables in KINDS.items():
        given = os.environ | {"EGAD_CACHE_DIR": "off"} | variables
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", PROGRAM],
            env=given,
            capture_output=True,
            text=True,
            check=True,
        )
        found[kind] = done.stdout.strip().split("|")
    digests = {each[0] for each in found.values()}
    assert len(digests) == 1, found
    assert len({each[3] for each in found.values()}) >= 3, found  # other kernels did run
    assert all(each[2].endswith(each[3]) for each in found.values())
