"""Tests of the studies have the fixtures and the helpers of those of the library."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "tests/workflow")]
pytest_plugins = ["tests.conftest", "tests.workflow.conftest"]
