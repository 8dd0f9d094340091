"""A small chain of files, made as the pipeline makes them: shards, a table, a folder, a figure."""

import pandas as pd
import pytest

from egad.cli.recorded import recorded
from egad.settings import Settings
from egad.stage_settings import Collect, Evolve, PostprocessSolids, select
from egad.tables import parquet
from egad.tables.objects import REJECTED


def table(path, text):
    parquet.write(pd.DataFrame([{"id": text, "stage": "", "reason": ""}]), REJECTED, path)


@pytest.fixture
def made(tmp_path, monkeypatch):
    """The folder `results/egad` below the working directory."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results/egad"
    (folder / "meshes").mkdir(parents=True)
    shards = [folder / f"parts/solids-{shard}.parquet" for shard in (0, 1, 2)]
    with recorded("evolve", select(Settings(seed=5), Evolve), []):
        table(folder / "archive.parquet", "archive")
    for shard, path in enumerate(shards):
        settings = select(Settings(), PostprocessSolids)
        with recorded("postprocess", settings, [folder / "archive.parquet"], shard=shard):
            table(path, f"shard {shard}")
    with recorded("collect", select(Settings(), Collect), shards, [folder / "meshes"]):
        table(folder / "objects.parquet", "objects")
        (folder / "meshes/a.obj").write_text("a")
        (folder / "meshes/b.obj").write_text("b")
    with recorded(
        "compare", None, [folder / "objects.parquet", folder / "meshes"], [folder / "map.svg"]
    ):
        table(folder / "comparison.parquet", "comparison")
        (folder / "map.svg").write_text("<svg/>")
    return folder
