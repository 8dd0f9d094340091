import pytest
import trimesh
from described_hands import box_urdf
from typer.testing import CliRunner

from egad.data import released
from egad.grasps import LabelParameters
from egad.grippers import GRIPPERS, Gripper
from egad.map_elites.parameters import EvolutionParameters
from egad.pipeline.cli import origins  # noqa: F401 (it adds its commands)
from egad.pipeline.cli.common import app
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select
from egad.pipeline.provenance import record
from egad.pipeline.stages.simulate import SimulatedTrials
from egad.tables import parquet
from egad.tables.objects import REJECTED

ROWS = [{"id": name, "stage": "", "reason": ""} for name in "ab"]


def egad(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture
def joined(tmp_path, monkeypatch):
    """A table that a command of the pipeline made of two others."""
    monkeypatch.chdir(tmp_path)
    for row in ROWS:
        parquet.write(parquet.pd.DataFrame([row]), REJECTED, tmp_path / f"{row['id']}.parquet")
    done = egad("join", "--by", "id", "--out", "all/rows.parquet", "a.parquet", "b.parquet")
    assert done.exit_code == 0, done.output
    return tmp_path / "all/rows.parquet"


def test_a_command_notes_what_it_read(joined):
    noted = parquet.origin_of(joined)
    assert [name for name, _ in noted["inputs"]] == ["../a.parquet", "../b.parquet"]
    assert (noted["stage"], noted["arguments"]) == ("join", {"by": ["id"]})


@pytest.mark.usefixtures("joined")
def test_provenance_prints_a_tree():
    said = egad("provenance", "all/rows.parquet").output.splitlines()
    assert said[0].startswith("all/rows.parquet: join (by id), code ")
    assert said[1] == "└─ a.parquet and 1 more: no provenance recorded"


def test_verify_tells_by_its_status_and_names_the_file(joined):
    assert egad("verify", "all").exit_code == 0
    data = bytearray(joined.read_bytes())
    data[10] ^= 1
    joined.write_bytes(data)
    done = egad("verify", "all")
    assert done.exit_code == 1
    assert "all/rows.parquet: altered" in done.output


def test_an_input_from_elsewhere_is_not_taken_for_one_of_the_same_name(tmp_path, monkeypatch):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    done = egad("archive", released(), "--out", "results/egad/archive.parquet")
    assert done.exit_code == 0, done.output
    assert egad("verify", "results/egad").exit_code == 0
    lines = egad("provenance", "results/egad/archive.parquet").output.splitlines()
    assert lines[1].startswith("└─ elsewhere:archive.parquet: missing; its sha256 was ")


def test_files_that_settings_name_are_inputs(tmp_path):
    mesh, code, weights = (tmp_path / name for name in ("hand.stl", "mine.py", "net.pt"))
    for path in (mesh, code, weights):
        path.write_text("")
    own = {
        "measures": {"complexity": f"{code}:size"},
        "keep_solid": {"kind": "mesh", "mesh": str(mesh), "size": [0.3, 0.3, 0.3]},
        "detectors": {"net": {"detector": "ggcnn", "weights": str(weights)}},
        "targets": {"detectors": ["net"]},
    }
    whole = Settings.model_validate(own)
    assert set(record.named_files(select(whole, EvolutionParameters))) == {mesh, code}
    tried = select(whole, SimulatedTrials, "egad_75mm", "net")
    assert record.named_files(tried) == [weights]
    code.unlink()
    assert record.named_files(select(whole, EvolutionParameters)) == [mesh]


def test_the_file_of_a_hand_and_its_meshes_are_inputs(tmp_path):
    finger = tmp_path / "finger.stl"
    trimesh.creation.box((0.01, 0.02, 0.04)).export(finger)
    mesh = f'<mesh filename="{finger.name}"/>'
    hand = box_urdf(tmp_path / "hand.urdf", changes={'<box size="0.01 0.021 0.0445"/>': mesh})
    whole = Settings(grippers=GRIPPERS | {"mine": Gripper.from_file(hand)})
    assert set(record.named_files(select(whole, LabelParameters, "mine"))) == {hand, finger}


def test_the_hash_of_settings_follows_their_values():
    one, same, other = (select(Settings(seed=seed), EvolutionParameters) for seed in (1, 1, 2))
    assert record.settings_hash(one) == record.settings_hash(same)
    assert record.settings_hash(one) != record.settings_hash(other)
