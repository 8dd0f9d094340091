"""What is noted of a stage follows from its parameters."""

import hashlib
from pathlib import Path
from typing import Annotated

import pytest

from egad.exchange.sums import read_sums
from egad.pipeline.parameters import Input, Jobs, NotNoted, Output, Renamed, Shard
from egad.pipeline.provenance.record import origin_of_run, run_recorded


def stage(
    tables: Annotated[dict[str, Path], Input(names="grippers")],
    folder: Annotated[Path, Input(files=lambda given: [given["folder"] / "chosen"])],
    shard: Shard,
    out: Annotated[Path, Output()],
    network: Annotated[Path, Output(files=("weights", "card"))],
    beside: Annotated[Path | None, Input()] = None,
    ending: Annotated[str, Renamed("format")] = "obj",
    hint: Annotated[str, NotNoted()] = "",
    units: str | None = None,
    jobs: Jobs = 1,
) -> None:
    """Write two files and a folder."""
    del tables, folder, shard, beside, ending, hint, units, jobs
    out.write_text("page")
    network.mkdir()
    for name in ("weights", "card", "scratch"):
        (network / name).write_text(name)


stage.__module__ = "egad.pipeline.stages.merge"  # of which the code is noted


@pytest.fixture
def given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    for name in ("a", "b", "in/chosen", "in/other"):
        (tmp_path / name).write_text(name)
    return {
        "tables": {"yumi": tmp_path / "a", "panda": tmp_path / "b"},
        "folder": tmp_path / "in",
        "shard": (2, 5),
        "out": tmp_path / "page.html",
        "network": tmp_path / "network",
    }


@pytest.fixture
def whole(given):
    return given | {"beside": None, "ending": "stl", "hint": "x", "units": None, "jobs": 7}


def test_inputs_are_hashed_in_the_order_of_the_parameters(whole, tmp_path):
    inputs = origin_of_run(stage, whole).inputs
    assert [path.relative_to(tmp_path).as_posix() for path, _ in inputs] == ["a", "b", "in/chosen"]
    assert [digest for _, digest in inputs] == [
        hashlib.sha256(name.encode()).hexdigest() for name in ("a", "b", "in/chosen")
    ]


def test_arguments_are_all_that_decides_the_result(whole):
    arguments = origin_of_run(stage, whole).arguments
    assert arguments == {"grippers": ["yumi", "panda"], "shard": 2, "shards": 5, "format": "stl"}
    changed = origin_of_run(stage, whole | {"jobs": 1, "hint": "y"})
    assert changed == origin_of_run(stage, whole)


def test_files_that_are_no_tables_have_their_sums_beside_them(given, tmp_path):
    run_recorded(stage, **given)
    sums, noted = read_sums(tmp_path / "page.html.sha256")
    assert list(sums) == [tmp_path / "page.html"]
    assert (noted["stage"], noted["arguments"]["format"]) == ("merge", "obj")
    written = {path.name for path in (tmp_path / "network").iterdir()}
    assert written == {"weights", "card", "scratch", "weights.sha256", "card.sha256"}
