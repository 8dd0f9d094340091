"""How much of egad one call loads: someone who came for grasps pays for no simulator."""

import subprocess
import sys

import pytest

CODE = """
import sys, trimesh, egad
box = trimesh.creation.box((0.05, 0.04, 0.03))
{call}
print(*sorted(name for name in sys.modules if name.partition(".")[0] == "egad"))
"""


@pytest.mark.parametrize(
    ("call", "most"),
    [
        ("egad.stable_poses(box)", 25),
        ("egad.sample_grasps(box, 'panda', n=5)", 60),
        ("egad.measure(box, max_candidates=512)", 80),
    ],
)
def test_a_call_loads_few_modules(call, most):
    command = [sys.executable, "-W", "ignore", "-c", CODE.format(call=call)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert len(loaded) < most, f"{len(loaded) - most + 1} too many of: {', '.join(loaded)}"
    below = {"bench", "detectors", "evalset", "exchange", "learning", "report", "sim"}
    assert [name for name in loaded if f"{name}.".split(".")[1] in below] == []
