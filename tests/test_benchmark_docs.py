"""The examples of docs/benchmark.md work as they stand."""

import re
from pathlib import Path

import trimesh

import egad

PAGE = (Path(__file__).parents[1] / "docs/benchmark.md").read_text()


def test_the_example_of_a_detector_grasps_a_ball():
    code = next(
        block for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "def " in block
    )
    names = {}
    exec(code, names)  # noqa: S102 (our own page)
    ball = {"ball": trimesh.creation.icosphere(3, 0.025)}
    found = egad.run_benchmark(
        names["highest_point"], ball, rounds=3, scenes=["single"], noise=["none"], rule="none"
    )
    assert found.rates()[0].success.value == 1
