"""A small chain of files, made as the pipeline makes them: shards, a table, a folder, a figure."""

import json
import signal

import pandas as pd
import pytest
from noted_stage import stage

from egad.evolution import EvolutionParameters, PostprocessSolids
from egad.measures import CellsAndDiversities
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad_workflow.settings import Settings, select


def table(path, text):
    parquet.write(pd.DataFrame([{"id": text, "stage": "", "reason": ""}]), REJECTED, path)


@pytest.fixture
def made(tmp_path, monkeypatch):
    """The folder `results/egad` below the working directory."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results/egad"
    (folder / "meshes").mkdir(parents=True)
    shards = [folder / f"parts/solids-{shard}.parquet" for shard in (0, 1, 2)]
    with stage("evolve", select(Settings(seed=5), EvolutionParameters), []):
        table(folder / "archive.parquet", "archive")
    for shard, path in enumerate(shards):
        settings = select(Settings(), PostprocessSolids)
        with stage("postprocess", settings, [folder / "archive.parquet"], shard=shard):
            table(path, f"shard {shard}")
    with stage("collect", select(Settings(), CellsAndDiversities), shards, [folder / "meshes"]):
        table(folder / "objects.parquet", "objects")
        (folder / "meshes/a.obj").write_text("a")
        (folder / "meshes/b.obj").write_text("b")
    with stage(
        "compare", None, [folder / "objects.parquet", folder / "meshes"], [folder / "map.svg"]
    ):
        table(folder / "comparison.parquet", "comparison")
        (folder / "map.svg").write_text("<svg/>")
    return folder


@pytest.fixture
def soon():
    """Ends a test that reads what never ends."""

    def late(*_):
        raise TimeoutError("this does not end")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(
    params=["/dev/zero", "/", "../outside", "../link", "../never", "../loop", "../here/link"]
)
def stranger(made, soon, request, tmp_path, monkeypatch):  # noqa: ARG001 (it limits the time)
    """A folder of which a file names, as what it was made from, something that is not to be read.

    The working directory is beside it.
    """
    folder = tmp_path / "strange/folder"
    folder.mkdir(parents=True)
    (tmp_path / "strange/outside").write_text("of somebody else")
    (tmp_path / "strange/link").symlink_to("/")
    (tmp_path / "strange/never").symlink_to("/dev/zero")
    (tmp_path / "strange/loop").symlink_to("loop")
    (tmp_path / "strange/here").mkdir()
    (tmp_path / "strange/here/link").symlink_to("../outside")
    monkeypatch.chdir(tmp_path / "strange/here")
    noted = parquet.origin_of(made / "objects.parquet") | {"inputs": [[request.param, "00"]]}
    (folder / "plain.txt").write_text("")
    digest = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    (folder / "SHA256SUMS").write_text(f"# egad-origin {json.dumps(noted)}\n{digest}  plain.txt\n")
    return folder
