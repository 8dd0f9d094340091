"""A kind of gripper, and the body of one, has an entry in every table that goes by them."""

import pytest

from egad.bench.failures.features import RAYS
from egad.detectors.parameters import FOR_KIND
from egad.grasps.labels import LABELS
from egad.grippers import GRIPPERS, HandBody, body_of
from egad.grippers.bodies import OF_KIND
from egad.grippers.kinds import Kind
from egad.sim.cup import FREE, ON_ARM
from egad.sim.hands import HANDS


def subclasses(cls):
    return {each for child in cls.__subclasses__() for each in (child, *subclasses(child))}


@pytest.mark.parametrize("table", [OF_KIND, LABELS, ON_ARM, FREE, FOR_KIND, RAYS])
def test_every_kind_is_in_each_table(table):
    assert set(table) == {kind.name for kind in subclasses(Kind)}


def test_every_body_can_be_built_in_an_engine():
    assert set(HANDS) == subclasses(HandBody)


@pytest.mark.parametrize("name", GRIPPERS)
def test_a_body_reaches_as_far_as_its_kind_says(name):
    gripper = GRIPPERS[name]
    (begin, end), parts = gripper.kind.span, body_of(gripper).parts()
    assert begin < 0 <= end
    if gripper.kind.closes:
        assert max(part.box[1, 2] for part in parts) == pytest.approx(end)
        assert min(part.box[0, 2] for part in parts[:2]) == pytest.approx(begin)
    else:
        assert max(part.box[1, 2] for part in parts) == pytest.approx(begin)  # its seal is below
