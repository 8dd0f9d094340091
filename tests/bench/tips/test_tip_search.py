"""The search for fingertips: draws, elites, races, resumption, and what is held out."""

import json

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad import Gripper
from egad.bench.hands import HandTrials
from egad.bench.tips import FingertipDesign, TipSearch, design_tips
from egad.bench.tips.base import base_of
from egad.bench.tips.design import split_targets
from egad.bench.tips.search import TIP_DESIGNS, _may_win, draw_design, elites, search_tips
from egad.errors import UserError
from egad.objects import EVALUATION_SET, load, named_meshes
from egad.tables import parquet

QUICK = HandTrials(drops=1, search_drops=1, tries=1, naive=1, errors="none", noise="none")
SPACE = {"length": (0.01, 0.02), "width": (0.014, 0.018), "thickness": 0.006}
HAND = Gripper(opening=0.09, force=20)
BOXES = {
    name: trimesh.creation.box(sides)
    for name, sides in (
        ("flat", (0.03, 0.05, 0.03)),
        ("cube", (0.03, 0.03, 0.03)),
        ("long", (0.025, 0.08, 0.03)),
        ("tall", (0.03, 0.03, 0.06)),
    )
}


def search(**changes):
    values = {"tips": SPACE, "evaluations": 4, "generation": 2, "trials": QUICK, "judged": QUICK}
    return TipSearch(**values | changes)


def row(number, opening, length, rates, problems=""):
    design = FingertipDesign(length=length)
    return {
        "design": number,
        "dimensions": design.model_dump_json(),
        "problems": problems,
        "opening": opening,
        "rates": rates,
    }


def test_elites_are_the_best_of_each_cell_that_tried_all_objects():
    rows = [
        row(0, 0.055, 0.021, [0.5, 0.5]),
        row(1, 0.051, 0.029, [1.0, 0.5]),  # the same cell
        row(2, 0.061, 0.029, [0.25, 0.25]),
        row(3, 0.051, 0.031, [1.0]),  # dropped
        row(4, 0.071, 0.031, [1.0, 1.0], "thin"),
    ]
    assert [each["design"] for each in elites(rows, 2)] == [1, 2]


def test_a_design_is_dropped_only_when_it_is_clearly_behind():
    assert _may_win([0.0, 0.0, 0.0, 0.0], None)
    assert not _may_win([0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.9, 1.0, 0.0])
    assert _may_win([0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.5])  # behind by 0.125, error 0.47
    assert _may_win([0.0], [1.0])  # of one object, the error is not known


def test_draws_stay_in_their_ranges_and_do_not_depend_on_order():
    settings = search(tips=SPACE | {"groove_direction": ("along", "across"), "angle": (-5.0, 5.0)})
    parents = [row(0, 0.05, 0.0199, [1.0])]
    for given in ([], parents):
        designs = [draw_design(settings, given, number) for number in range(60)]
        assert designs[::-1] == [draw_design(settings, given, n) for n in reversed(range(60))]
        lengths = np.array([each.length for each in designs])
        assert (lengths >= 0.01).all()
        assert (lengths <= 0.02).all()
        assert {each.thickness for each in designs} == {0.006}
        assert {each.groove_direction for each in designs} == {"along", "across"}
    near = np.mean([each.length > 0.0175 for each in designs])
    assert near > 0.5  # around the parent, not uniform


def test_a_search_resumes_and_does_not_depend_on_the_number_of_processes(tmp_path):
    base, settings = base_of("boxes", HAND), search()
    targets = named_meshes(BOXES)[:2]
    paths = [tmp_path / name for name in ("whole.parquet", "parallel.parquet", "cut.parquet")]
    whole = search_tips(base, settings, targets, "none", paths[0], 1)
    works = whole[whole["problems"] == ""]
    assert len(works) == 4
    assert all(len(rates) == 2 and 0 <= min(rates) <= max(rates) <= 1 for rates in works["rates"])
    assert works["opening"].to_numpy() == pytest.approx(np.full(4, 0.078), abs=1e-5)
    search_tips(base, settings, targets, "none", paths[1], 2)
    half = whole[: int(works.index[1]) + 1]  # as if interrupted after the first generation
    parquet.write(half, TIP_DESIGNS, paths[2], parquet.notes(paths[0]))
    search_tips(base, settings, targets, "none", paths[2], 1)
    assert len({path.read_bytes() for path in paths}) == 1
    weak = base_of("boxes", HAND.model_copy(update={"force": 21.0}))
    larger = [
        each._replace(mesh=lambda: trimesh.creation.box((0.05, 0.05, 0.05))) for each in targets
    ]
    for given in (
        (base, search(seed=1), targets, "none"),
        (weak, settings, targets, "none"),
        (base, settings, larger, "none"),
        (base, settings, targets, "paper"),
    ):
        with pytest.raises(UserError, match=r"whole\.parquet is of other settings, hand or obj"):
            search_tips(*given, paths[0], 1)


def test_whole_columns_are_held_out():
    targets = named_meshes(load(EVALUATION_SET))
    settings = search(objects=10)
    chosen, others = split_targets(targets, settings)
    columns = [{each.label[1] for each in half} for half in (chosen, others)]
    assert columns[0].isdisjoint(columns[1])
    assert (len(chosen), len(others)) == (10, 21)
    again, _ = split_targets(targets[::-1], settings)
    assert [each.label for each in again] == [each.label for each in chosen]


def test_tips_are_designed_and_judged_on_other_objects(tmp_path):
    settings = search(evaluations=2)
    found = design_tips("boxes", HAND, settings, named_meshes(BOXES), tmp_path, rule="none")
    judged = set(found.cards["mujoco"].table["label"])
    assert judged.isdisjoint(found.chosen_on)
    assert judged | set(found.chosen_on) == set(BOXES)
    assert list(found.cards["mujoco"].hands) == ["boxes", "boxes with tips"]
    assert found.hand.opening == pytest.approx(0.078, abs=1e-5)
    assert Gripper.from_file(tmp_path / "hand.xml", force=20).opening == pytest.approx(0.078)
    first = trimesh.load_mesh(tmp_path / "first_tip.stl")
    volume = found.design.width * 0.006 * (found.design.length + found.design.overlap)
    assert first.volume == pytest.approx(1e9 * volume, rel=1e-4)
    assert first.bounds[0] == pytest.approx([0, 0, 0], abs=1e-4)
    assert (tmp_path / "tips.3mf").stat().st_size > 500
    dimensions = pd.read_parquet(tmp_path / "designs.parquet")["dimensions"]
    assert found.design.length in [json.loads(text)["length"] for text in dimensions]


def test_a_space_without_a_possible_design_is_refused(tmp_path):
    thin = search(tips={"thickness": 0.0008, "length": (0.03, 0.04)})
    message = r"none of 40 designs of this space works; most often, the first tip cannot be printed"
    with pytest.raises(UserError, match=message):
        search_tips(base_of("boxes", HAND), thin, named_meshes(BOXES), "none", tmp_path / "x", 1)


@pytest.mark.parametrize(
    ("tips", "message"),
    [
        ({"lenght": 0.01}, r"tips has no dimension lenght; allowed: length, width"),
        ({"length": (0.02, 0.01)}, r"tips\.length is \[0\.02, 0\.01\]; allowed: \[LOW, HIGH\]"),
        ({"angle": (-50.0, 0.0)}, "angle"),
        ({"groove_direction": "up"}, "groove_direction"),
    ],
)
def test_bad_spaces_are_refused(tips, message):
    with pytest.raises((UserError, ValueError), match=message):
        search(tips=tips)
