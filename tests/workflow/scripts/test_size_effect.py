import pandas as pd
import pytest
import size_effect
import trimesh
from partial_tables import fill_columns

from egad.measures import SizeEffect
from egad.measures.parameters import SizeEffectParameters
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SIZE_EFFECT
from egad_workflow.settings import Settings, select

WANTED = SizeEffect(fractions=[0.5, 1.2], percentiles=[75.0], grasps=5, repeats=1)
SETTINGS = select(Settings(size_effect=WANTED), SizeEffectParameters, "yumi")


def evalset(*values):
    names = [f"{letter}0" for letter in "ABCDEFG"[: len(values)]]
    frame = pd.DataFrame({"label": names, "graspability": values, "object_label": names})
    return fill_columns(EVAL49, frame) if names else parquet.empty(EVAL49)


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
