import re
from pathlib import Path

import pytest
import results_page
from rule_texts import TEXT

RESULTS = results_page.results()

WILDCARDS = {
    "D": "{dataset}",
    "G": "{gripper}",
    "P": "{detector}",
    "FORMAT": "{format}",
    "N": "{shard}",
}
# what jobs pass to each other
BETWEEN = ("{dataset}/parts/", "{dataset}/epochs/")


def pattern(path):
    """A path of the manual as rules have it."""
    parts = re.split(r"([A-Z]+)", path)
    return "".join(WILDCARDS.get(part, part) for part in parts)


def outputs():
    """The files and folders that rules make, in `results/`."""
    blocks = re.findall(r"^    output:\n((?: {8}.*\n)+)", TEXT, flags=re.MULTILINE)
    return sorted({path for block in blocks for path in re.findall(r'"results/([^"]+)"', block)})


def test_every_column_has_a_meaning():
    schemas = [each.columns for each in RESULTS if each.columns is not None]
    assert len(schemas) > 15
    for schema in schemas:
        for field in schema:
            assert field.metadata[b"meaning"], field.name


@pytest.mark.parametrize("path", [each.path for each in RESULTS if each.columns is not None])
def test_a_rule_makes_the_table_where_the_manual_says(path):
    file = Path("results", pattern(path))
    folders = [f'directory("{folder}")' for folder in file.parents]
    assert any(output in TEXT for output in (f'"{file}"', *folders))


@pytest.mark.parametrize("made", [each for each in outputs() if not each.startswith(BETWEEN)])
def test_the_manual_has_what_a_rule_makes(made):
    """By its own path, in a folder, or as the folder of what is listed."""
    listed = [pattern(each.path) for each in RESULTS]
    assert any(
        path in (made, f"{made}/") or path.startswith(f"{made}/") or is_in(made, path)
        for path in listed
    )


def is_in(made, path):
    return path.endswith("/") and made.startswith(path)


def test_no_path_is_listed_twice():
    paths = [each.path for each in RESULTS]
    assert len(set(paths)) == len(paths)
