import pandas as pd
import pytest
import size_effect
import trimesh

from egad.measures import SizeEffect
from egad.measures.parameters import SizeEffectParameters
from egad.measures.size_effect import curves
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SIZE_EFFECT
from egad_workflow.settings import Settings, select

WANTED = SizeEffect(fractions=[0.5, 1.2], percentiles=[75.0], grasps=5, repeats=1)
SETTINGS = select(Settings(size_effect=WANTED), SizeEffectParameters, "yumi")


def evalset(*values):
    names = [f"{letter}0" for letter in "ABCDEFG"[: len(values)]]
    frame = pd.DataFrame({"label": names, "graspability": values, "object_label": names})
    blank = {f.name: "" if str(f.type) == "string" else 0 for f in EVAL49 if f.name not in frame}
    return frame.assign(**blank)[EVAL49.names]


@pytest.mark.parametrize(
    ("values", "chosen"),
    [
        ((0.001, 0.004, 0.002, 0.003), ["B0", "D0", "A0"]),
        ((0.003, 0.003, 0.003, 0.003, 0.003), ["A0", "C0", "E0"]),
        ((0.001, 0.002), ["B0", "A0"]),
        ((0.001,), ["A0"]),
        ((), []),
    ],
)
def test_the_objects_shown_are_the_easiest_the_middle_and_the_hardest(values, chosen):
    assert size_effect.spread(evalset(*values))["label"].tolist() == chosen


def test_the_stage_writes_the_curves_in_that_order(tmp_path):
    parquet.write(evalset(0.001, 0.003, 0.002), EVAL49, tmp_path / "eval49.parquet")
    for name in ("A0", "B0", "C0"):
        trimesh.creation.box([0.1, 0.2, 0.1]).export(tmp_path / f"{name}.obj")
    out = tmp_path / "out.parquet"
    size_effect.run(SETTINGS, tmp_path / "eval49.parquet", tmp_path, out)
    table = parquet.read(out, SIZE_EFFECT)
    assert table["name"].tolist() == ["B0", "B0", "C0", "C0", "A0", "A0"]
    assert table["quality"].notna().tolist() == [True, False] * 3


def test_an_empty_evaluation_set_gives_an_empty_table(tmp_path):
    parquet.write(parquet.empty(EVAL49), EVAL49, tmp_path / "eval49.parquet")
    size_effect.run(SETTINGS, tmp_path / "eval49.parquet", tmp_path, tmp_path / "out.parquet")
    assert parquet.read(tmp_path / "out.parquet", SIZE_EFFECT).empty


def test_meshes_that_cannot_be_used_are_named_and_the_others_measured(tmp_path):
    box = trimesh.creation.box([40, 20, 30])
    box.export(tmp_path / "box.obj")
    box.update_faces(box.face_normals[:, 2] < 0.5)
    box.export(tmp_path / "open.ply")
    (tmp_path / "list.obj").write_text("milk, eggs")
    files = {name: tmp_path / name for name in ("open.ply", "box.obj", "list.obj", "gone.stl")}
    table, reasons = curves(SETTINGS, files, "mm", 1)
    assert set(table["name"]) == {"box.obj"}
    assert list(reasons) == ["open.ply", "list.obj", "gone.stl"]
    assert "open" in reasons["open.ply"]
