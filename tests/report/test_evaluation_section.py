"""The section of the evaluation set."""

from egad.grippers import GRIPPERS
from egad.report.evaluation import evaluation_view
from egad.tables import parquet
from egad.tables.evaluation import EVAL49


def test_the_hardest_row_is_on_top_and_simple_objects_are_on_the_left():
    view = evaluation_view(parquet.empty(EVAL49), 3, 2, {}, (), GRIPPERS["panda"])
    labels = [[slot.label for slot in row] for row in view.slots]
    assert labels == [["C0", "C1"], ["B0", "B1"], ["A0", "A1"]]
