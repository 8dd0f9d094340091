import numpy as np
import pytest
from typer.testing import CliRunner

import egad
from egad.cli.commands import app
from egad.grasps.suction import limits, resists
from egad.report.hand import cup_entry, cup_facts, cup_page, spring_shapes

CUP = egad.SuctionCup(radius=0.01, height=0.025, sides=12, vacuum_force=20, friction=0.4)


@pytest.mark.parametrize(
    ("part", "place"),
    [("pull", 2), ("across", 0), ("across", 1), ("torsion", 5), ("bending", 3), ("bending", 4)],
)
def test_a_limit_is_where_the_cup_lets_go(part, place):
    load = np.zeros((2, 6))
    load[:, place] = getattr(limits(CUP), part) * np.array([0.999, 1.001])
    assert resists(CUP, load).tolist() == [True, False]


def test_the_springs_are_drawn_with_their_lengths():
    assert len(spring_shapes(CUP)) == 3 * CUP.sides
    expected = {1: 2 * 0.01 * np.sin(np.pi / 12), 2: 0.01, 3: np.hypot(0.01, 0.025)}  # by color
    for shape, color in spring_shapes(CUP):
        span = np.linalg.norm(shape.vertices[:, None] - shape.vertices[None], axis=2).max()
        assert span == pytest.approx(expected[color], rel=0.02)


def test_facts_and_page_name_the_cup():
    facts = cup_facts(CUP)
    assert facts["pull along the axis"] == "20 N (2.04 kg)"
    assert facts["force across the axis"].startswith("4.62 N")  # 0.4 * 20 / sqrt(3)
    page = cup_page("mine", egad.Gripper(cup=CUP), CUP)
    assert "sampler: mine.py:f" in cup_entry("mine", egad.Gripper(cup=CUP, sampler="mine.py:f"))
    assert "The suction cup mine" in page
    assert "default-src 'none'" in page


def test_inspect_shows_a_cup_of_the_configuration(tmp_path):
    done = CliRunner().invoke(
        app, ["gripper", "inspect", "cup_15mm", "--out", str(tmp_path / "cup.html")]
    )
    assert done.exit_code == 0, done.output
    assert "15 mm across" in done.output
    assert "cup_15mm:" in done.output
    assert (tmp_path / "cup.html").is_file()
