import json
import os

import pytest

from egad.errors import UserError
from egad.tables import parquet
from egad_workflow.provenance_tree import tree


def drawn(path):
    """The lines down to what made each file, paths relative to the folder of the results."""
    return [line.partition(" (")[0].partition(",")[0] for line in tree(path)]


def test_the_tree_goes_back_to_the_seed(made):
    os.chdir(made)
    assert drawn(made / "comparison.parquet") == [
        f"{made}/comparison.parquet: compare",
        f"├─ {made}/objects.parquet: collect",
        f"│  └─ {made}/parts/solids-0.parquet and 2 more: postprocess",
        f"│     └─ {made}/archive.parquet: evolve",
        f"└─ {made}/meshes: collect",
        f"   └─ {made}/parts/solids-0.parquet and 2 more: postprocess",
    ]
    lines = list(tree(made / "objects.parquet"))
    assert "postprocess (shard 0), seed 0, settings " in lines[1]
    assert "evolve, seed 5, settings " in lines[2]


@pytest.mark.parametrize(("name", "stage"), [("map.svg", "compare"), ("meshes/a.obj", "collect")])
def test_files_that_are_no_tables_have_theirs_beside_them(made, name, stage):
    assert next(tree(made / name)).startswith(f"{made / name}: {stage}, ")


def test_what_is_not_as_it_was_or_not_there_is_said(made):
    (made / "parts/solids-1.parquet").unlink()
    (made / "parts/solids-2.parquet").write_bytes(b"another")
    _, first, _, second, third = tree(made / "objects.parquet")
    assert "solids-0.parquet: postprocess" in first
    assert "solids-1.parquet: missing; its sha256 was " in second
    assert "solids-2.parquet: ALTERED since; its sha256 was " in third


def test_a_file_that_nothing_is_noted_of(made):
    (made / "notes.txt").write_text("mine")
    assert list(tree(made / "notes.txt")) == [f"{made}/notes.txt: no provenance recorded"]


@pytest.mark.parametrize("noted", ['{"stage": 1}', '{"program": "1", "inputs": 3}'])
def test_damaged_notes_are_named(made, noted):
    (made / "map.svg.sha256").write_text(f"# egad-origin {noted}\n")
    with pytest.raises(UserError, match="its provenance record is damaged"):
        list(tree(made / "map.svg"))


def test_names_cannot_move_the_cursor(made):
    path = made / "a\x1b[2J.txt"
    path.write_text("")
    assert "\x1b" not in next(tree(path))


def test_what_a_stranger_names_is_not_read(stranger):
    _, line = tree(stranger / "plain.txt")
    assert "not checked" in line or "loop: missing" in line


@pytest.mark.parametrize("name", ["a\0b", "a" * 5000])
def test_what_cannot_be_a_path_is_not_there(made, name):
    noted = parquet.origin_of(made / "objects.parquet") | {"inputs": [[name, "00"]]}
    (made / "map.svg.sha256").write_text(f"# egad-origin {json.dumps(noted)}\n")
    assert ": missing" in list(tree(made / "map.svg"))[1]


def test_an_input_is_hashed_once(made, monkeypatch):
    hashed = []
    monkeypatch.setattr("egad_workflow.provenance_tree.checksum", hashed.append)
    list(tree(made / "comparison.parquet"))
    assert sorted(set(hashed)) == sorted(hashed)
