"""The examples of docs/benchmark.md work as they stand."""

import importlib
import re
import sys
from pathlib import Path

import pytest
import trimesh

import egad

PAGE = (Path(__file__).parents[2] / "docs/benchmark.md").read_text()
BLOCKS = [
    re.sub("^ {4}", "", text, flags=re.MULTILINE) if indent else text
    for indent, text in re.findall(r"^( *)```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE)
]


@pytest.fixture
def detector(tmp_path, monkeypatch):
    """The first example in its file, where it can be imported."""
    (tmp_path / "my_detector.py").write_text(BLOCKS[0])
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield
    sys.modules.pop("my_detector", None)


@pytest.mark.usefixtures("detector")
def test_the_example_of_a_detector_grasps_a_ball():
    detect = importlib.import_module("my_detector").highest_point
    ball = {"ball": trimesh.creation.icosphere(3, 0.025)}
    few = {"rounds": 3, "scenes": ["single"], "noise": ["none"], "rule": "none"}
    assert egad.run_benchmark(detect, ball, **few).rates()[0].success.value == 1


@pytest.mark.slow
@pytest.mark.usefixtures("detector")
def test_the_example_in_python_runs(tmp_path, capsys):
    trimesh.creation.icosphere(3, 0.03).export(tmp_path / "mug.obj")
    exec(BLOCKS[1].replace("rounds=10", "rounds=4"), {})  # noqa: S102 (our own page)
    assert len(capsys.readouterr().out.splitlines()) == 6
    assert (tmp_path / "pile-3.gif").exists()


def test_all_examples_are_run_here():
    assert len(BLOCKS) == 2
