"""Simulated labels: what holds when it is shaken and lifted, and what does not."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from worlds import EACH_FAST_ENGINE, HAND

from egad.geometry import Bundle
from egad.sim import simulated_labels
from egad.sim.jaws import Hand
from egad.sim.model import build
from egad.sim.parameters import Lifting, SimulatedLabel, SimulatedLabelParameters
from egad.sim.simulated_labels import simulate_labels
from egad.tables.columns import vector_names
from egad.tables.grasping import MOTIONS
from egad.tables.outcomes import Outcome

SIDE = 0.04
CUBE = trimesh.creation.box((SIDE,) * 3)
UP, DOWN, ACROSS = (0, 0, 1), (0, 0, -1), (1, 0, 0)


def parameters(engine="mujoco", grasps=10, force=20.0, friction=0.5):
    return SimulatedLabelParameters.model_validate(
        {
            "gripper": HAND.model_copy(update={"force": force}),
            "quality": {"friction": friction},
            "trials": Lifting(),
            "simulated_label": SimulatedLabel(engine=engine, grasps=grasps),
        }
    )


def grasp(center=(0, 0, 0), axis=ACROSS, approach=DOWN, free=True):
    row = {"collision_free": free, "robust_quality": 0.0, "width": SIDE}
    for name, vector in (("center", center), ("axis", axis), ("approach", approach)):
        row |= dict(zip(vector_names(name), vector, strict=True))
    return row


def labelled(mass, *rows, **settings):
    model = build(CUBE, mass / SIDE**3, Bundle())
    return simulate_labels(model, pd.DataFrame(rows), parameters(**settings))


@EACH_FAST_ENGINE
def test_the_load_decides_when_a_grasp_slips(engine):
    """Two pads of 20 N and friction 0.5 carry 20 N; shaking asks for 11 m/s2, lifting for 12."""
    middle = grasp()
    found = {
        mass: labelled(mass, middle, engine=engine)["simulated_outcome"].item()
        for mass in (0.1, 1.4, 5.0)
    }
    assert found == {0.1: "success", 1.4: "success", 5.0: "slipped_shaking"}


@EACH_FAST_ENGINE
def test_what_is_held_moves_little_and_what_is_off_the_middle_more(engine):
    """A cube of 100 g is pushed to the middle of the hand by 5 mm while the fingers close."""
    middle, aside = (grasp((x, 0, 0)) for x in (0.0, 0.005))
    found = labelled(0.1, middle, aside, engine=engine)
    assert found["simulated_success"].tolist() == [True, True]
    shift, turn, shaken, swung = (found[name].astype(float) for name in MOTIONS)
    assert shift[0] < 0.0005
    assert shift[1] == pytest.approx(0.005, abs=0.0005)
    assert turn.max() < 0.02
    assert shaken.max() < 0.001
    assert swung.max() < 0.05
    assert set(found["simulated_engine"]) == {engine}


@EACH_FAST_ENGINE
def test_what_is_not_between_the_fingers_is_missed(engine):
    found = labelled(0.1, grasp((0, 0.1, 0)), engine=engine)
    assert found["simulated_outcome"].item() == "missed"
    assert not found["simulated_success"].item()
    assert np.isfinite(found["simulated_closing_shift"].astype(float)).all()
    assert found["simulated_shaking_shift"].isna().all()


@EACH_FAST_ENGINE
def test_no_grasp_depends_on_those_before(engine):
    rows = [grasp((0, 0, z), approach=way) for z in (0, 0.01) for way in (DOWN, UP)]
    together = labelled(1.0, *rows, engine=engine)
    apart = pd.concat([labelled(1.0, row, engine=engine) for row in rows], ignore_index=True)
    pd.testing.assert_frame_equal(together, apart, check_exact=True)


def test_only_the_first_free_grasps_are_simulated():
    rows = [grasp(free=free) for free in (False, True, True, False, True)]
    found = labelled(0.1, *rows, grasps=2)
    assert found["simulated_outcome"].notna().tolist() == [False, True, True, False, False]
    assert found["simulated_success"].notna().tolist() == [False, True, True, False, False]


def test_the_hand_is_shaken_and_comes_back(monkeypatch):
    places = []

    def noted(steer):
        return lambda hand, place: places.append(place) or steer(hand, place)

    monkeypatch.setattr(Hand, "steer", noted(Hand.steer))
    monkeypatch.setattr(simulated_labels, "lift_and_hold", lambda *_: (Outcome.SUCCESS, None))
    labelled(0.1, grasp())
    heights = np.array([place.height for place in places])
    angles = np.array([place.angle for place in places])
    assert np.abs(heights - heights[0]).max() == pytest.approx(0.026, abs=0.0005)
    assert np.abs(angles - angles[0]).max() == pytest.approx(np.radians(25), abs=0.01)
    assert heights[-1] == pytest.approx(heights[0], abs=1e-4)
    assert angles[-1] == pytest.approx(angles[0], abs=1e-4)
    # by hand: the largest second difference of the heights, per square of the time step
    assert np.abs(np.diff(heights, 2)).max() * 240**2 == pytest.approx(11.2, abs=0.5)


def test_a_simulation_that_explodes_is_an_outcome(monkeypatch):
    def explode(hand):
        hand.world.place(hand.world.pose(), (0.0, 0.0, 100.0))
        hand.world.step()

    monkeypatch.setattr(Hand, "close", explode)
    found = labelled(0.1, grasp())
    assert found["simulated_outcome"].item() == "failed"
    assert found["simulated_success"].isna().item()
    assert found[list(MOTIONS)].isna().all(axis=None)
