import subprocess
import sys
from pathlib import Path

import pytest
from compiled import reached_kernels

HERE = Path(__file__).parents[1]


@pytest.mark.parametrize("name", ["reeb/test_graph.py", "cppn/test_voxels.py"])
def test_reading_the_source_finds_the_kernels_that_importing_loads(name):
    code = f"""
import runpy, sys
runpy.run_path({str(HERE / name)!r})
from numba.core.dispatcher import Dispatcher
modules = [m for n, m in sys.modules.items() if n.startswith("egad.")]
kernels = (value for m in modules for value in vars(m).values() if isinstance(value, Dispatcher))
print(*{{kernel.__module__ for kernel in kernels}})
"""
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert reached_kernels(HERE / name) == set(loaded.split())
