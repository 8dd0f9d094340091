"""The examples of docs/detectors.md, and what docs/compare.md says of files of results."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml

from egad.bench.stats.records import COLUMNS
from egad.detectors import DetectorConfig
from egad.detectors.registry import make_detector
from egad.grippers import GRIPPERS
from egad_workflow.check import check

DOCS = Path(__file__).parents[2] / "docs"
PAGE, RESULTS = ((DOCS / name).read_text() for name in ("detectors.md", "compare.md"))
HAND = GRIPPERS["egad_75mm"]


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    path = tmp_path_factory.mktemp("docs") / "across.py"
    code, *_ = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    path.write_text(code)
    return make_detector(DetectorConfig(detector=f"{path}:across"))


@pytest.mark.parametrize("turn", [0.0, 0.6, -1.3])
def test_it_holds_a_box_across_its_short_side(look, example, turn):
    view = look(trimesh.creation.box((0.03, 0.09, 0.05)), 0.04, -0.03, turn)
    (grasp,) = example(view, HAND, np.random.default_rng(0))
    off = (grasp.angle - turn + np.pi / 2) % np.pi - np.pi / 2
    assert abs(off) < 0.05
    np.testing.assert_allclose(grasp.center[:2], (0.04, -0.03), atol=0.004)
    assert grasp.infeasibility(HAND) is None
    assert grasp.width == pytest.approx(0.05, abs=0.006)
    assert grasp.tip == pytest.approx(0.02, abs=0.001)


def test_its_configurations_are_allowed():
    for text in re.findall(r"```yaml\n(.*?)```", PAGE, flags=re.DOTALL):
        config = yaml.safe_load(text)
        shipped = {"antipodal-depth": {"detector": "antipodal-depth"}}
        check({**config, "detectors": shipped | config["detectors"]})


def test_every_column_of_a_robots_file_is_explained():
    assert all(f"| `{name}` |" in RESULTS for name in COLUMNS)
