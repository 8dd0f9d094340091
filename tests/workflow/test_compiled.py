import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
from compiled import SCRIPTS, TESTS, modules_with_kernels, reached_kernels

from egad._util import kernel_cache
from egad_workflow import precompile

HERE = Path(__file__).parents[1]


def loaded_kernels(path):
    """The modules with compiled code that are there once a file has run."""
    code = f"""
import runpy, sys
sys.path.insert(0, {str(SCRIPTS)!r})
runpy.run_path({str(path)!r})
from numba.core.dispatcher import Dispatcher
modules = [m for n, m in sys.modules.items() if n.startswith("egad.")]
kernels = (value for m in modules for value in vars(m).values() if isinstance(value, Dispatcher))
print(*{{kernel.__module__ for kernel in kernels}})
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.parametrize("name", ["measures/reeb/test_graph.py", "evolution/test_voxels.py"])
def test_reading_the_source_finds_the_kernels_that_importing_loads(name):
    assert reached_kernels(HERE / name) == loaded_kernels(HERE / name)


@pytest.mark.parametrize("module", sorted(modules_with_kernels()))
def test_compiled_code_is_tested_by_a_file_in_the_folder_of_its_package(module):
    """So that it runs where every index is checked."""
    folder = TESTS / module.split(".")[1]
    assert any(module in reached_kernels(path) for path in folder.rglob("test_*.py"))


def test_kernels_are_compiled_once_for_each_state_of_their_sources(tmp_path, monkeypatch, capsys):
    started = []

    def mapper(_, works):
        started.append(works)
        if len(started) == 1:
            raise RuntimeError("no space left")
        return works

    monkeypatch.setattr(kernel_cache, "kernel_folder", lambda: tmp_path)
    monkeypatch.setattr(precompile, "workers", lambda _: nullcontext(mapper))
    precompile.compile_kernels()
    assert "compiled at their first use: no space left" in capsys.readouterr().err
    for _ in range(2):
        precompile.compile_kernels()
    assert len(started) == 2
    monkeypatch.setattr(kernel_cache, "kernel_sources_version", lambda: "edited")
    precompile.compile_kernels()
    assert len(started) == 3
