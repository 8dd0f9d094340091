import json
import subprocess
import sys

import pytest

from egad import cli
from egad.settings import Settings
from egad.stage_settings import Merge, select


def egad(*arguments):
    code = "from egad.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        check=False,
        capture_output=True,
        text=True,
    )


def test_help_lists_every_stage_and_imports_nothing_heavy():
    code = (
        "import sys; from egad import cli\n"
        "print([n for n in ('numba', 'trimesh', 'pybullet', 'scipy') if n in sys.modules])"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert loaded.stdout.strip() == "[]"
    shown = egad("--help").stdout
    for name in ("evolve", "postprocess", "grasp-label", "rescale", "select-eval", "simulate"):
        assert name in shown


def test_a_damaged_table_is_one_sentence_without_a_traceback(tmp_path):
    broken = tmp_path / "archive.parquet"
    broken.write_bytes(b"PAR1 and then nothing")
    result = egad("archive", broken, "--out", tmp_path / "out.parquet")
    assert result.returncode == 1
    assert "archive.parquet: not a readable Parquet file" in result.stderr
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "out.parquet").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--opening", "-1"], "opening"),
        (["--opening", "0.05", "--rule", "papr"], "egad-script"),
        ([], "--opening"),
        (["--opening", "0.05", "--format", "step"], "obj, stl"),
    ],
)
def test_rescale_says_what_is_allowed(tmp_path, arguments, sentence):
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    result = egad("rescale", tmp_path, "--out", tmp_path / "out", *arguments)
    assert result.returncode == 1
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr


def test_stage_settings_travel_as_json():
    merge = select(Settings(), Merge)
    assert cli._parse(Merge, json.dumps(json.loads(merge.model_dump_json()))) == merge
