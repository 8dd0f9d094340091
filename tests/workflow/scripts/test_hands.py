import hands
import pandas as pd
import pytest
import trimesh
from partial_tables import fill_columns

from egad.bench.hands import ComparedHands, HandTrials
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.hands import HAND_ATTEMPTS
from egad_workflow.settings import Settings, select


@pytest.fixture
def evaluation(tmp_path):
    rows = pd.DataFrame(
        {"label": ["A0"], "id": ["abc"], "graspability": 0.001, "object_label": ["M14_3"]}
    )
    parquet.write(fill_columns(EVAL49, rows), EVAL49, tmp_path / "eval49.parquet")
    trimesh.creation.box([0.1, 0.2, 0.1]).export(tmp_path / "M14_3.obj")
    return tmp_path / "eval49.parquet"


def test_the_stage_compares_the_named_hands_and_writes_a_card(evaluation, tmp_path, monkeypatch):
    monkeypatch.setattr(hands, "HandTrials", lambda: HandTrials(drops=1, search_drops=1, tries=1))
    settings = select(Settings(), ComparedHands)
    card, attempts = tmp_path / "card.html", tmp_path / "attempts.parquet"
    hands.run(settings, ["panda", "egad_75mm"], evaluation, tmp_path, card, attempts)
    table = parquet.read(attempts, HAND_ATTEMPTS)
    assert list(dict.fromkeys(table["hand"])) == ["panda", "egad_75mm"]
    assert set(table["label"]) == {"A0"}
    page = card.read_text()
    assert "panda" in page
    assert "egad_75mm" in page
