"""Samplers by name: the antipodal one as ever, suction, and functions of users."""

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.errors import RejectedError, UserError
from egad.evolution import EvolutionParameters as Evolve
from egad.evolution.evaluation import first_estimate
from egad.geometry import RayCaster
from egad.grasps import label_parameters, vectors
from egad.grasps.labels import rate_grasps, sample_for_labels
from egad.grasps.samplers import check_sampler
from egad.grasps.sampling import Labeller
from egad.grasps.suction import sample_suction, suction_poses
from egad.grippers import hand_body
from egad.random import generator
from egad.tables.grasping import GRASPS
from egad_workflow.settings import Settings, select

EXAMPLE = "examples/sampler.py:from_above"
COLUMNS = [name for name in GRASPS.names if name not in ("id", "label")]


def own(tmp_path, body, **gripper):
    """A gripper whose sampler has this body."""
    path = tmp_path / f"mine{len(list(tmp_path.iterdir()))}.py"  # a file is loaded once
    path.write_text(
        "import numpy as np\n\n\ndef sample(mesh, gripper, n, rng):\n"
        "    poses, widths, quality = np.tile(np.eye(4), (n, 1, 1)), np.full(n, 0.04), np.ones(n)\n"
        + "".join(f"    {line}\n" for line in body.split("\n"))
    )
    return egad.Gripper(**{"opening": 0.08, "sampler": f"{path}:sample"} | gripper)


@pytest.fixture
def bar():
    return trimesh.creation.box((0.04, 0.03, 0.1))


def test_jaws_get_the_antipodal_grasps_as_ever(bar):
    settings = label_parameters(egad.gripper("panda"), 40, 3)
    found = Labeller(settings)(bar, bar.center_mass, generator(3, "x"))
    caster, rng, body = RayCaster(bar), generator(3, "x"), hand_body(settings.gripper)
    pairs, _ = sample_for_labels(caster, settings, rng)
    expected = rate_grasps(caster, bar.center_mass, pairs, settings, rng, body)
    pd.testing.assert_frame_equal(found.table, expected)
    assert (found.reason, len(found.table)) == ("", 40)


def test_a_cup_gets_suction_grasps(bar):
    bar = trimesh.creation.box((0.08, 0.09, 0.1))
    grasps = egad.sample_grasps(bar, "cup_30mm", 60, seed=2)
    table = grasps.to_frame()
    assert set(COLUMNS) == set(table.columns)
    seed = int(generator(2, "sample_grasps").integers(2**32))
    expected = sample_suction(bar, egad.SuctionCup(radius=0.015), 60, seed=seed)
    np.testing.assert_allclose(grasps.poses, suction_poses(expected), atol=1e-12)
    np.testing.assert_array_equal(grasps.quality, expected["quality"])
    np.testing.assert_array_equal(grasps.collision_free, expected["collision_free"])
    # on the surface of the box, approached along its inward normals
    on_face = np.isclose(np.abs(grasps.contacts[:, 0]), bar.extents / 2, atol=1e-9)
    assert on_face.any(axis=1).all()
    np.testing.assert_allclose(vectors(table, "normal0"), -vectors(table, "approach"))
    assert not grasps.widths.any()


def test_a_function_of_the_user_is_a_sampler(bar):
    hand = egad.Gripper(opening=0.08, sampler=EXAMPLE)
    grasps = egad.sample_grasps(bar, hand, 50, seed=1)
    assert 10 < len(grasps) <= 50
    np.testing.assert_allclose(grasps.poses[:, :3, 2], np.tile([0, 0, -1], (len(grasps), 1)))
    inside = np.abs(grasps.contacts[:, :, :2]) <= [0.02 + 1e-9, 0.015 + 1e-9]
    assert inside.all()  # the contacts are on the sides of the bar
    np.testing.assert_allclose(
        np.linalg.norm(grasps.contacts[:, 1] - grasps.contacts[:, 0], axis=1), grasps.widths
    )
    facing = np.einsum("nk,nk->n", grasps.normals[:, 0], grasps.poses[:, :3, 0])
    assert (facing < 0).all()
    assert grasps.collision_free.all() == np.all(grasps.to_frame()["fits"])


def test_a_quality_of_a_users_sampler_is_no_success_rate_of_a_cup(tmp_path, bar):
    body = "poses[:, 2, 3] = 0.05\nreturn poses, 0 * widths, 7 * quality"
    cup = {"opening": 0.08, "cup": egad.SuctionCup(radius=0.01)}
    table = egad.sample_grasps(bar, own(tmp_path, body, **cup), 3).to_frame()
    assert (table["robust_quality"] == 7).all()
    assert table[["robust_quality_std", "robust_success_rate"]].isna().all(axis=None)


def test_the_hand_of_a_user_sampler_collides_where_it_would(tmp_path, bar):
    """Along z: the palm of a Panda begins 34 mm behind the contacts, its fingertips 10.5 before."""
    sizes = {key: getattr(egad.gripper("panda"), key) for key in ("finger_length", "finger_width")}
    places = "poses[:, 2, 3] = [-0.05 + 0.03, -0.05 + 0.036, -0.05, -0.07]"
    hand = own(tmp_path, f"{places}\nreturn poses, widths, quality", **sizes)
    table = egad.sample_grasps(bar, hand, 4).to_frame()
    assert table["fits"].tolist() == [True, False, True, True]
    across = own(
        tmp_path,
        "poses[:, :3, :3] = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\nreturn poses, widths, quality",
    )
    assert not egad.sample_grasps(bar, across, 4).collision_free.any()  # along the long side


def test_graspability_and_evolution_take_the_qualities_of_a_user_sampler(tmp_path, bar):
    hand = own(tmp_path, "return poses, widths, rng.uniform(0, 1, n)")
    found = egad.measure(bar, hand, max_candidates=4096)
    assert found.graspability == pytest.approx(0.75, abs=0.03)
    settings = select(Settings(grippers={"mine": hand}, graspability={"gripper": "mine"}), Evolve)
    estimate = first_estimate("x", settings)(bar)
    assert (estimate.grasps, estimate.value) == (512, pytest.approx(0.75, abs=0.07))


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("return poses, widths", "must return poses"),
        ("return poses[:, :3], widths, quality", r"shapes \(5, 3, 4\)"),
        ("poses[1, 0, 0] = np.nan\nreturn poses, widths, quality", "not finite: grasp 1"),
        ("poses[2, 0, 0] = 2\nreturn poses, widths, quality", "not a rotation .*: grasp 2"),
        ("widths[1] = 0.09\nreturn poses, widths, quality", "width above the opening .*: grasp 1"),
        ("quality[0] = np.inf\nreturn poses, widths, quality", "quality .*: grasp 0"),
        (
            "return np.tile(poses, (2, 1, 1)), np.ones(10), np.ones(10)",
            "asked for at most 5 grasps",
        ),
    ],
)
def test_what_is_no_grasps_is_refused_by_name(tmp_path, bar, body, says):
    with pytest.raises(UserError, match=f"mine0.py:sample.*{says}"):
        egad.sample_grasps(bar, own(tmp_path, body), 5)


def test_a_sampler_that_fails_or_finds_nothing_rejects_the_object(tmp_path, bar):
    with pytest.raises(RejectedError, match=r"failed in line 6 of mine0.py: ZeroDivisionError"):
        egad.sample_grasps(bar, own(tmp_path, "return 1 / 0"), 5)
    with pytest.raises(RejectedError, match="found no grasp"):
        nothing = "return poses[:0], widths[:0], quality[:0]"
        egad.sample_grasps(bar, own(tmp_path, nothing), 5)


def test_samplers_that_do_not_go_with_a_hand_are_refused(tmp_path):
    with pytest.raises(UserError, match="for jaws"):
        check_sampler(egad.Gripper(cup=egad.SuctionCup(), sampler="antipodal"))
    with pytest.raises(UserError, match="for cups"):
        check_sampler(egad.Gripper(opening=0.08, sampler="suction"))
    with pytest.raises(UserError, match="no such file"):
        check_sampler(egad.Gripper(opening=0.08, sampler=f"{tmp_path}/none.py:f"))
    with pytest.raises(UserError, match="no function g"):
        path = tmp_path / "some.py"
        path.write_text("def f(mesh, gripper, n, rng): ...\n")
        check_sampler(egad.Gripper(opening=0.08, sampler=f"{path}:g"))
