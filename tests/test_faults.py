"""The list of faults that the tests are tried with fits today's code."""

from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
FAULTS = yaml.safe_load((ROOT / "tests/faults/faults.yaml").read_text())


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault["id"])
def test_a_fault_has_its_place(fault):
    text = (ROOT / fault["file"]).read_text()
    assert text.count(fault["old"]) == 1
    assert list(ROOT.glob(fault["tests"]))
