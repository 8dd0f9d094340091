import re
from pathlib import Path

import pytest

from egad.pipeline import results_page

ROOT = Path(__file__).parents[2]
RULES = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
WILDCARDS = {
    "D": "{dataset}",
    "G": "{gripper}",
    "P": "{detector}",
    "SET": "{training_set}",
    "SEED": "{seed}",
    "N": "{shard}",
}


def test_the_pages_are_what_the_stages_and_rules_declare(monkeypatch):
    monkeypatch.chdir(ROOT)
    for path, text in results_page.files().items():
        assert path.read_text(encoding="utf-8") == text


def test_every_column_has_a_meaning():
    outputs = [output for each in results_page.artefacts() for output in each.outputs]
    schemas = [output.schema for output in outputs if output.schema is not None]
    assert len(schemas) > 15
    for schema in schemas:
        for field in schema:
            assert field.metadata[b"meaning"], field.name


def tables():
    outputs = [output for each in results_page.artefacts() for output in each.outputs]
    return sorted(output.path for output in outputs if output.schema is not None)


@pytest.mark.parametrize("path", tables())
def test_a_rule_makes_the_table_where_the_manual_says(path):
    parts = re.split(r"([A-Z]+)", path)
    file = Path("results", "".join(WILDCARDS.get(part, part) for part in parts))
    folders = [f'directory("{folder}")' for folder in file.parents]
    assert any(output in RULES for output in (f'"{file}"', *folders))
