"""The workflow as a module of another one, as the guide says."""

from pathlib import Path

import pandas as pd
from test_pages import blocks

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "docs/guides/other-workflow.md"


def test_another_workflow_uses_its_rules(empty, tmp_path):
    """With fewer objects and measured coarsely, to be quick; otherwise to the letter."""
    for block in blocks(GUIDE):
        if block.file:
            (tmp_path / block.file).write_text(block.text)
    config = tmp_path / "config.yaml"
    few = config.read_text().replace("objects: 10", "objects: 4")
    coarse = "graspability: {candidates: 64}\n  postprocess: {max_candidates: 128}\n"
    config.write_text(f"{few}  shards: 1\n  {coarse}")
    (tmp_path / "path/to").mkdir(parents=True)
    (tmp_path / "path/to/egad").symlink_to(ROOT)
    empty.make("--cores", 2, configs=())
    objects = pd.read_parquet(tmp_path / "results/small/objects.parquet")
    heavy = pd.read_csv(tmp_path / "heavy.csv")
    assert heavy["mass"].tolist() == sorted(objects["mass"], reverse=True)[:3]
