"""The example and the configuration of docs/vision.md work as they stand; needs the extra."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from egad.detectors import DetectorConfig
from egad.detectors.registry import make_detector
from egad.grippers import GRIPPERS
from egad.plugins import find
from egad_workflow.check import check

PAGE = (Path(__file__).parents[2] / "docs" / "vision.md").read_text()
HAND = GRIPPERS["egad_75mm"]


def test_a_network_of_ones_own_is_trained_and_proposes_grasps(images, view, tmp_path):
    torch = pytest.importorskip("torch")
    (code,) = re.findall(r"```python\n(\"\"\"mine.py.*?)```", PAGE, flags=re.DOTALL)
    (tmp_path / "mine.py").write_text(code)
    find(f"{tmp_path}/mine.py:train", "", "function")(images, tmp_path / "mine.pt", 16)
    weights = torch.load(tmp_path / "mine.pt", weights_only=True)
    assert all(value.isfinite().all() for value in weights.values())
    mine = DetectorConfig(detector=f"{tmp_path}/mine.py:Mine", weights=str(tmp_path / "mine.pt"))
    found = make_detector(mine)(view, HAND, np.random.default_rng(0))
    assert len(found) > 0
    assert all(grasp.infeasibility(HAND) is None for grasp in found)


def test_its_configurations_are_allowed():
    texts = re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL)
    assert len(texts) == 2
    for config in map(yaml.safe_load, texts):
        shipped = {"antipodal-depth": {"detector": "antipodal-depth"}}
        check({**config, "detectors": shipped | config.get("detectors", {})})
