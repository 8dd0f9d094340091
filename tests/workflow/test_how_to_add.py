"""A copy of the package to which a measure, a format and a stage are added as CONTRIBUTING says."""

import json
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from forks import python
from partial_tables import write_rows

from egad.tables import parquet
from egad.tables.grasping import GRASPS, SCALES
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n# (\S+?)(?:, class (\w+))?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# A block that is added to a class is put behind what this finds.
CLASS_HEAD = r"^class {}\(.*?^(?=    (?:@|def ))"
ADDED = {
    "egad/measures/compactness.py",
    "egad/measures/parameters.py",
    "egad/tables/weights.py",
    "egad/exchange/grasps/plain.py",
    "workflow/scripts/weigh.py",
    "workflow/Snakefile",
    "workflow/rules/weigh.smk",
}
# Snakemake without the kernels, which the copy does not need.
QUICK = """
include: "workflow/Snakefile"


onstart:
    pass
"""


def blocks():
    """The code of the section of CONTRIBUTING: file, class that it is added to, text."""
    return BLOCK.findall((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The sources with all of these."""
    folder = tmp_path_factory.mktemp("copy")
    skipped = shutil.ignore_patterns("__pycache__")
    for name in ("egad", "egad_workflow", "workflow", "config", "profiles", "envs", "docs"):
        shutil.copytree(ROOT / name, folder / name, ignore=skipped)
    shutil.copy(ROOT / "Snakefile", folder)
    for file, name, text in blocks():
        path = folder / file
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        if name:
            end = re.search(CLASS_HEAD.format(name), before, re.DOTALL | re.MULTILINE).end()
            path.write_text(f"{before[:end]}{text}\n{before[end:]}", encoding="utf-8")
        else:
            path.write_text(f"{before}\n{text}" if before else text, encoding="utf-8")
    (folder / "quick.smk").write_text(QUICK)
    return folder


@pytest.fixture(scope="module")
def dataset(copy):
    """A folder with the tables that an export and the stage read: two objects, three grasps."""
    folder = copy / "results/tiny"
    (folder / "meshes").mkdir(parents=True)
    for path, schema, columns in (
        ("objects", OBJECTS, {"label": ["A00_0", "B00_0"], "volume": [1e-6, 3e-6]}),
        ("grasps/panda", GRASPS, {"label": ["A00_0"] * 3, "quality": [0.1, 0.2, 0.3]}),
        ("rescaled/panda/scales", SCALES, {"opening": [0.08]}),
    ):
        write_rows(schema, pd.DataFrame(columns), folder / f"{path}.parquet")
    return folder


def run(copy, *words, module="egad.cli"):
    """What a command in the copy prints."""
    path = "import sys; sys.path.append('docs/manual')"
    code = f"{path}; from {module} import main; sys.exit(main())"
    done = python(
        ["-c", code, *words],
        folder=copy,
        environment=os.environ | {"PYTHONPATH": str(copy), "COLUMNS": "200"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_guide_names_the_files_and_no_other():
    assert {file for file, *_ in blocks()} == ADDED


def test_a_stage_runs_and_notes_what_it_was_made_from(copy, dataset):
    (copy / "tiny.yaml").write_text(
        yaml.safe_dump({"datasets": {"tiny": {"source": "primitives", "objects": 2}}})
    )
    words = ["--snakefile", "quick.smk", "--cores", 1, "--configfile", "tiny.yaml"]
    target = "results/tiny/weights.parquet"
    run(copy, *words, "--allowed-rules", "weigh", "--", target, module="snakemake.cli")
    table = pd.read_parquet(dataset / "weights.parquet")
    density = Settings().material.density
    np.testing.assert_allclose(table["weight"], [1.62e-6 * density, 4.86e-6 * density])
    noted = parquet.origin_of(dataset / "weights.parquet")
    assert (noted["stage"], noted["arguments"]) == ("weigh", {"dataset": "tiny"})
    assert [name for name, _ in noted["inputs"]] == ["objects.parquet"]
    assert noted["settings"]
    assert noted["code"]
    assert "weigh (dataset tiny)" in run(copy, "provenance", dataset / "weights.parquet")


def test_the_manuals_have_the_stage_the_format_and_the_measure(copy):
    (copy / "results").mkdir(exist_ok=True)
    run(copy, module="manual")
    manual = (copy / "results/README.md").read_text(encoding="utf-8")
    assert "| `D/weights.parquet` | what the objects weigh on the moon |" in manual
    assert "## `D/weights.parquet`\n" in manual
    assert "| `weight` | double | N | weight on the moon |" in manual
    settings = (copy / "config/README.md").read_text(encoding="utf-8")
    assert " or obj or plain or robosuite " in settings
    assert "| `compactness_power` | `1.0` | exponent of compactness |" in settings


def test_the_workflow_plans_the_stage_and_the_format(copy):
    (copy / "own.yaml").write_text(yaml.safe_dump({"targets": {"exports": ["plain"]}}))
    files = ["results/egad/weights.parquet", "results/egad/exchange/egad_75mm-plain"]
    words = ["--dry-run", "--cores", 1, "--configfile", "own.yaml", "--", *files]
    planned = run(copy, *words, module="snakemake.cli")
    assert re.search(r"^weigh +1$", planned, re.MULTILINE)
    assert re.search(r"^export +1$", planned, re.MULTILINE)
    assert re.search(r"^join_grasps +1$", planned, re.MULTILINE)


def test_a_format_is_written_and_notes_what_it_was_made_from(copy, dataset):
    out = dataset / "exchange/panda-plain"
    run(copy, "export", dataset, "--gripper", "panda", "--format", "plain", "--out", out)
    table = pd.read_csv(out / "grasps.csv")
    assert table["quality"].tolist() == [0.1, 0.2, 0.3]
    assert table["opening"].tolist() == [0.08] * 3
    head = (out / "SHA256SUMS").read_text().splitlines()[0]
    noted = json.loads(head.partition("egad-origin ")[2])
    assert noted["stage"] == "export"
    assert noted["arguments"] == {"gripper": "panda", "format": "plain"}
    assert [name for name, _ in noted["inputs"]] == ["../../grasps/panda.parquet"]


def test_a_measure_has_its_setting_and_takes_it(copy):
    code = """
import sys, trimesh
from egad.measures.custom import plugin_value
from egad.measures.parameters import CustomMeasures
from egad_workflow.archive_settings import provenance
from egad_workflow.check import check
from egad_workflow.check import node_at
from egad_workflow.settings import select
from egad.evolution import EvolutionParameters
name = "egad.measures.compactness:compactness"
axes = CustomMeasures(complexity=name, compactness_power=2)
print(node_at(("measures", "compactness_power"))["description"])
print(plugin_value(name, trimesh.creation.box(), axes))
whole = check({"measures": {"complexity": name, "compactness_power": 3.0}})
notes = provenance(select(whole, EvolutionParameters))
print(notes["measures"]["compactness_power"], len(notes["source"]["complexity"]))
"""
    environment = os.environ | {"PYTHONPATH": str(copy)}
    done = python(["-c", code], folder=copy, environment=environment)
    description, value, noted = done.stdout.splitlines()
    assert description == "exponent of compactness"
    assert float(value) == pytest.approx((np.pi / 6) ** (2 / 3))  # of a cube
    assert noted == "3.0 16"
