"""The household scans are as in PyBullet, and the rows as the README says."""

from pathlib import Path

import numpy as np
import published
import pytest
import trimesh

CUBE = trimesh.creation.box((0.02, 0.02, 0.02))


@pytest.fixture
def scans(tmp_path):
    """One object of two cubes side by side."""
    lines = []
    for number, x in enumerate((-0.02, 0.02)):
        lines += [f"o part{number}", *(f"v {x + a} {b} {c}" for a, b, c in CUBE.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in CUBE.faces + 1 + 8 * number]
    (tmp_path / "two_collision.obj").write_text("\n".join(lines))
    (tmp_path / "two_visual.obj").write_text("\n".join(lines))
    (tmp_path / "two.urdf").write_text('<inertial><mass value="0.7"/></inertial>')
    return tmp_path


def test_each_group_is_a_hull_and_the_mass_is_that_of_the_file(scans):
    (made,) = published.household(scans)
    assert made.id == "two"
    assert [part.volume for part in made.model.parts] == pytest.approx([0.02**3] * 2)
    bounds = made.model.mesh.bounds
    assert np.sort(bounds[1] - bounds[0]) == pytest.approx([0.02, 0.02, 0.06])
    assert made.model.mass == made.model.scaled(0.7).mass == 0.7
    assert next(iter(published.household(scans, 0.5))).model.scaled(2.0).mass == 0.5


def test_the_leaderboard_rows_follow_its_protocol():
    from egad_workflow.leaderboard import PROTOCOLS, read_protocol  # noqa: PLC0415

    path = Path(__file__).parents[2] / "leaderboard" / PROTOCOLS / "clutter-mujoco.yaml"
    _, settings = read_protocol(path)
    rows = [row for row in published.rows() if row.part == "leaderboard"]
    assert {row.detector for row in rows} == set(published.DETECTORS)
    assert all(row.clutter == settings.clutter for row in rows)


def test_the_piles_follow_all_rules_of_neugraspnet():
    rows = [row for row in published.rows() if row.part == "piles"]
    assert {row.changes for row in rows} == {("sizes", "hulls", "mass")}
    meshes = [row for row in published.rows() if row.part == "piles-meshes"]
    assert {row.changes for row in meshes} == {("sizes", "mass")}
    assert [row.clutter for row in meshes] == [row.clutter for row in rows]
    assert {row.clutter.protocol.skips for row in rows} == {3}
    assert {row.detector: row.clutter.protocol.threshold for row in rows}["vgn"] == 0.5
