"""What is noted of what a job or a command writes."""

import hashlib
import json

import pandas as pd
import pytest

from egad import __version__
from egad.evolution import EvolutionParameters
from egad.io.sums import checksum
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad_workflow.provenance import recorded, settings_hash
from egad_workflow.settings import Settings, select

ROW = pd.DataFrame([{"id": "a", "stage": "b", "reason": "c"}])


@pytest.fixture(autouse=True)
def at_work(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def table(path):
    """Write a table; what is noted of it."""
    parquet.write(ROW, REJECTED, path)
    return parquet.origin_of(path)


def test_inputs_are_hashed_in_their_order(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    for path in (tmp_path / "b", tmp_path / "a", folder / "a.obj"):
        path.write_text(path.name)
    with recorded("join", inputs=[tmp_path / "b", tmp_path / "a", folder]):
        noted = table(tmp_path / "rows.parquet")
    digests = [hashlib.sha256(name.encode()).hexdigest() for name in ("b", "a")]
    assert noted["inputs"] == [["b", digests[0]], ["a", digests[1]], ["meshes", checksum(folder)]]


def test_inputs_are_hashed_as_they_are_read(tmp_path):
    """A job may replace what it has read."""
    (tmp_path / "a").write_text("before")
    with recorded("join", inputs=[tmp_path / "a"]):
        (tmp_path / "a").write_text("after")
        noted = table(tmp_path / "rows.parquet")
    assert noted["inputs"] == [["a", hashlib.sha256(b"before").hexdigest()]]


def test_settings_are_noted_by_their_hash_and_their_seed(tmp_path):
    settings = select(Settings(seed=5), EvolutionParameters)
    plain = json.loads(settings.model_dump_json())
    for number, given in enumerate((settings, plain)):
        with recorded("evolve", settings=given):
            noted = table(tmp_path / f"{number}.parquet")
        assert (noted["settings"], noted["seed"]) == (settings_hash(settings), 5)


@pytest.mark.parametrize("settings", [None, {}])
def test_a_job_without_settings_has_no_hash_and_no_seed(tmp_path, settings):
    with recorded("publish", settings=settings):
        noted = table(tmp_path / "rows.parquet")
    assert (noted["settings"], noted["seed"]) == (None, None)


def test_the_stage_its_code_and_its_arguments_are_noted(tmp_path):
    arguments = {"gripper": "yumi", "shard": "2", "units": None}
    with recorded("grasp_label", code="c0de", arguments=arguments):
        noted = table(tmp_path / "rows.parquet")
    assert (noted["program"], noted["stage"], noted["code"]) == (__version__, "grasp_label", "c0de")
    assert noted["arguments"] == {"gripper": "yumi", "shard": "2"}


def test_the_hash_of_settings_follows_their_values():
    one, same, other = (select(Settings(seed=seed), EvolutionParameters) for seed in (1, 1, 2))
    assert settings_hash(one) == settings_hash(same)
    assert settings_hash(one) != settings_hash(other)
    assert settings_hash({"a": 1, "b": 2}) == settings_hash({"b": 2, "a": 1})
