"""The evaluation set of meshes that users bring: all of them, or one of each cell."""

import pytest
import select_eval
import trimesh
from partial_tables import write_rows

from egad.evalset import EvalSelection
from egad.measures.reeb import graph as reeb
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.objects import OBJECTS, REJECTED, SOLIDS
from egad_workflow.settings import Settings, select

SETTINGS = Settings()
# The mug has walls of 2.5 mm, which are too thin to print at its size for an opening of 50 mm.
SIDES = {"box": (60, 40, 30), "bar": (90, 20, 20), "mug": (100, 100, 100), "foil": (80, 50, 0.4)}
PLACES = {"box": 0.0022, "bar": 0.0036, "mug": 0.0028, "foil": 0.0012}


def solid(name):
    box = trimesh.creation.box([side / 1000 for side in SIDES[name]])
    if name == "mug":
        hole = trimesh.creation.box([0.095, 0.095, 0.1])
        hole.apply_translation([0, 0, 0.0025])
        return box.difference(hole)
    return box


@pytest.fixture
def chosen(tmp_path):
    """Runs the stage on four solids."""

    def run(selection, opening=0.075, own=True):
        rows = []
        for name, graspability in PLACES.items():
            mesh = solid(name)
            rows.append(
                {
                    "id": name,
                    "complexity": 1.5,
                    "graspability": graspability,
                    "cell_confidence": 1.0,
                    "vertices": mesh.vertices.ravel(),
                    "faces": mesh.faces.ravel(),
                    "graph": reeb.pack(reeb.extract(mesh, SETTINGS.similarity)),
                }
            )
        objects, solids = tmp_path / "objects.parquet", tmp_path / "solids.parquet"
        write_rows(SOLIDS, rows, solids)
        kept = [{k: v for k, v in row.items() if k in OBJECTS.names} for row in rows]
        write_rows(OBJECTS, [row | {"label": row["id"]} for row in kept], objects)
        settings = select(SETTINGS, EvalSelection)
        gripper = settings.gripper.model_copy(update={"opening": opening})
        settings = settings.model_copy(update={"gripper": gripper})
        out, rejected = tmp_path / "eval49.parquet", tmp_path / "rejected.parquet"
        select_eval.run(settings, objects, [solids], [], selection, own, out, rejected)
        left_out = parquet.read(rejected, REJECTED).set_index("id")["reason"].to_dict()
        return parquet.read(out, EVAL49), left_out

    return run


def test_all_meshes_are_in_the_set_under_their_names_however_their_cells_fall(chosen, monkeypatch):
    monkeypatch.setitem(PLACES, "bar", PLACES["box"])
    table, left_out = chosen("all")
    assert table["label"].tolist() == table["object_label"].tolist() == sorted(SIDES)
    assert left_out == {}
    assert table["row"].tolist() == [3, 3, 5, 2]
    assert (table["nearest"] > 0).all()


@pytest.mark.parametrize(
    ("last", "places"), [("B1", [(0, 1), (0, 2), (1, 0), (1, 1)]), ("b", None)]
)
def test_a_set_whose_names_are_all_cells_lies_in_these_cells(chosen, monkeypatch, last, places):
    for old, new in zip(list(PLACES), ["B0", "A1", "A2", last], strict=True):
        monkeypatch.setitem(SIDES, new, SIDES["box" if old == "mug" else old])
        monkeypatch.setitem(PLACES, new, 0.002)
        monkeypatch.delitem(PLACES, old)
    table = chosen("all")[0]
    assert table["label"].tolist() == sorted(["B0", "A1", "A2", last])
    found = list(zip(table["row"], table["column"], strict=True))
    assert found == places if places else len(set(found)) == 1


def test_where_one_of_each_cell_is_wanted_the_others_are_named_with_reasons(chosen):
    table, left_out = chosen("cells")
    taken = table.set_index("id")["label"]
    assert set(taken.index) | set(left_out) == set(SIDES)
    assert "walls thinner than 1.2 mm" in left_out["foil"]
    assert "box" in taken.index
    assert "mug" in taken.index
    narrow, left_out = chosen("cells", opening=0.05)
    assert "mug" not in set(narrow["id"])
    assert "not printable for an opening of 50 mm: walls thinner" in left_out["mug"]


def test_another_object_of_a_cell_is_named(chosen, monkeypatch):
    monkeypatch.setitem(PLACES, "bar", PLACES["box"])
    table, left_out = chosen("cells")
    (name,) = {"box", "bar"} & set(left_out)
    other = "box" if name == "bar" else "bar"
    label = table.set_index("id").loc[other, "label"]
    assert left_out[name] == f"its cell {label} has another object: {other}"
    assert set(chosen("cells", own=False)[1]) == {"foil"}
