"""Detectors get what they ask for."""

import functools

import numpy as np
import pytest

from egad.detectors import Grasp, GraspPoses, choose, from_above, seen_by, wanted_input
from egad.detectors.base import DetectorError
from egad.detectors.registry import with_checked_answers
from egad.errors import UserError
from egad.grippers import GRIPPERS
from egad.tables.outcomes import Outcome


def of_view(view, _gripper, _rng):
    return [view]


def of_tsdf(tsdf, _gripper, _rng):
    return tsdf


def of_object_clouds(object_clouds, _gripper, _rng):
    return object_clouds


class OfCloud:
    def __call__(self, cloud, _gripper, _rng):
        return cloud


class Declared:
    observes = "views"

    def __call__(self, cloud, _gripper, _rng):
        return cloud


def of_anything(_, _gripper, _rng):
    return _


def of_several(*seen):
    return seen


def misnamed(point_cloud, _gripper, _rng):
    return point_cloud


class Misnamed:
    def __call__(self, image, _gripper, _rng):
        return image


@pytest.mark.parametrize(
    ("detect", "name"),
    [
        (of_view, "view"),
        (of_tsdf, "tsdf"),
        (OfCloud(), "cloud"),
        (of_object_clouds, "object_clouds"),
        (Declared(), "views"),
        (of_anything, "view"),
        (with_checked_answers(of_tsdf), "tsdf"),
        (functools.partial(of_tsdf), "tsdf"),
    ],
)
def test_the_input_is_known_from_signature_or_attribute(detect, name, observation):
    assert wanted_input(detect) == name
    assert seen_by(detect, observation) is getattr(observation, name)


def test_an_unknown_input_is_named():
    detect = OfCloud()
    detect.observes = "mesh"
    with pytest.raises(UserError, match=r"mesh.*views"):
        wanted_input(detect)


@pytest.mark.parametrize(
    ("detect", "name"),
    [
        (misnamed, "point_cloud"),
        (with_checked_answers(misnamed), "point_cloud"),
        (functools.partial(misnamed), "point_cloud"),
    ],
)
def test_a_first_parameter_of_another_name_is_refused_with_those_that_are_allowed(detect, name):
    with pytest.raises(UserError, match=rf"'{name}' is none of view, views, cloud, object_"):
        wanted_input(detect)


def returns_nothing(_view, _gripper, _rng):
    pass


@pytest.mark.parametrize("answer", [None, 3, [1, 2], (1, 2, 3), "grasp", [np.eye(4)]])
def test_an_answer_that_is_no_grasps_names_the_code_that_gave_it(answer):
    line = returns_nothing.__code__.co_firstlineno
    with pytest.raises(DetectorError, match=rf"{__file__}, line {line}.*NoneType None"):
        with_checked_answers(returns_nothing)(None, None, None)
    with pytest.raises(DetectorError, match="must return a list of grasps"):
        with_checked_answers(lambda *_: answer)(None, None, None)


def test_a_tuple_of_arrays_is_an_answer_of_poses():
    answer = (np.eye(4)[None].tolist(), [0.05], [1])
    found = with_checked_answers(lambda *_: answer)(None, None, None)
    assert isinstance(found, GraspPoses)
    assert found.poses.shape == (1, 4, 4)


def test_poses_are_not_from_above():
    with pytest.raises(DetectorError, match="benchmark"):
        from_above(GraspPoses(np.empty((0, 4, 4)), np.empty(0), np.empty(0)))


def test_grasps_in_the_frame_of_a_camera_are_an_error():
    """One of 0.6 m above the table sees an object in its middle; one grasp in place is enough."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, 2, 3] = (0.55, 0.58)
    answer = GraspPoses(poses, np.full(2, 0.05), np.ones(2))
    with pytest.raises(DetectorError, match=r"all 2 grasps are more than 0\.4 m .* of a camera"):
        choose(answer, GRIPPERS["panda"])
    above = [Grasp((100.0, 0.0, 30.0), 0.0, 0.05, 0.01, 1.0)]
    with pytest.raises(DetectorError, match="not in metres"):
        choose(above, GRIPPERS["panda"])
    poses[0, 2, 3] = 0.1
    assert choose(answer, GRIPPERS["panda"]).center == (0, 0, 0.1)
    poses[:, 2, 3] = (np.nan, 0.55)
    assert choose(answer, GRIPPERS["panda"]).center == (0, 0, 0.55)


def test_no_grasps_are_in_no_wrong_frame():
    for answer in ([], GraspPoses(np.zeros((0, 4, 4)), np.zeros(0), np.zeros(0))):
        assert choose(answer, GRIPPERS["panda"]) is Outcome.NO_GRASP
