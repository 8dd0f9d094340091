"""A table with one object: what happens there depends on the arguments alone."""

import numpy as np
import pytest
from failing import CUBE, EACH_FAST_ENGINE, PANDA, broken, nothing, rng

from egad.bench import TrialProtocol, TrialRunner
from egad.bench.failures.finding import failure_parameters
from egad.bench.failures.object_runner import ObjectRunner, open_runner
from egad.bench.failures.parameters import FailureSearch
from egad.detectors import Failure, Grasp
from egad.geometry import Bundle, Material
from egad.grasps import label_parameters
from egad.grasps.sampling import dataset_grasps
from egad.sim import ARMS, build, open_world
from egad.tables.outcomes import Outcome

MODEL = build(CUBE, Material().density, Bundle())
LABELLED = dataset_grasps(CUBE, "cube", label_parameters(PANDA, 50, 0))
EACH_WAY = pytest.mark.parametrize("from_above", [True, False])


def runner(engine, from_above, contact=None):
    settings = failure_parameters(PANDA, FailureSearch(depth_noise=0.1), contact=contact)
    return open_runner(engine, MODEL, LABELLED, settings, from_above=from_above)


@EACH_WAY
@EACH_FAST_ENGINE
def test_labelled_grasps_hold_and_can_be_repeated(engine, from_above):
    with runner(engine, from_above) as table:
        assert table.engine == engine
        rest = table.drop(rng())
        grasps = table.labelled(rest)
        assert 0 < len(grasps) <= 10
        assert all(table.can_do(grasp) for grasp in grasps)
        assert table.execute(rest, grasps[0]) == Outcome.SUCCESS
        table.drop(np.random.default_rng(5))  # something else in between
        assert table.execute(rest, grasps[0]) == Outcome.SUCCESS
        again = table.drop(rng())
    np.testing.assert_array_equal(again.matrix, rest.matrix)


@EACH_WAY
def test_proposals_are_ranked_and_feasible(from_above):
    def three(_view, _gripper, _rng):
        good = Grasp((0.0, 0.0, 0.03), 0.3, 0.06, 0.01, 0.5)
        wide = Grasp((0.0, 0.0, 0.03), 0.3, 0.5, 0.01, 0.9)
        return [good, wide, Grasp((0.01, 0.0, 0.03), 0.3, 0.06, 0.01, 0.7)]

    with runner("mujoco", from_above) as table:
        rest = table.drop(rng())
        found = table.propose(three, rest, rng())
        assert [each.quality for each in found] == [0.7, 0.5]
        assert table.propose(nothing, rest, rng()) == Outcome.NO_GRASP
        failure = table.propose(broken, rest, rng())
    assert isinstance(failure, Failure)
    assert "oops" in failure.text


@EACH_FAST_ENGINE
def test_a_grasp_from_above_is_carried_out_as_in_trials(engine):
    arm = ARMS["axis"](PANDA)
    with open_world(engine, [MODEL], arm.robot) as world:
        runner = TrialRunner(world, arm, TrialProtocol(engine=engine))
        table = ObjectRunner(engine, runner, lambda _: [])
        rest = table.drop(rng())
        x, y, z = rest.position.tolist()
        for shift in (0.0, 0.02, 0.2):
            grasp = Grasp((x + shift, y, z), 0.4, 0.08, 0.015, 1.0)
            expected = runner.carry_out(rest, grasp).outcome
            assert table.execute(rest, grasp.as_pose(PANDA)) == expected
