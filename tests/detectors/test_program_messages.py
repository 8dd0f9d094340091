"""Messages keep what they carry; what is none is refused."""

import io
import pickle

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from egad.detectors import Grasp, GraspPoses
from egad.detectors.messages import answered, packed, question, unpacked
from egad.grippers import GRIPPERS

SHAPES = arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4)
DTYPES = st.sampled_from(["|b1", "|u1", "<i2", "<i8", ">i4", "<f4", "<f8", ">f8"])


@given(arrays.arrays(DTYPES, SHAPES))
def test_an_array_comes_back_bit_by_bit(array):
    found = unpacked(packed({"a": [array]}))["a"][0]
    assert (found.dtype, found.shape) == (array.dtype, array.shape)
    assert found.tobytes() == array.tobytes()
    if found.size:
        found.flat[0] = 0  # it can be written to


def test_arrays_are_encoded_as_msgpack_numpy_does():
    """By hand, from the description of that package."""
    array = np.array([[1.0, 2.0, 3.0]], dtype="<f4")
    found = msgpack.unpackb(packed(array))
    data = b"\0\0\x80?\0\0\0@\0\0@@"
    assert found == {b"nd": True, b"type": "<f4", b"kind": b"", b"shape": [1, 3], b"data": data}
    number = {b"nd": False, b"type": "<f8", b"data": np.float64(0.5).tobytes()}
    assert unpacked(msgpack.packb(number)) == 0.5


class Boom:
    def __reduce__(self):
        return (print, ("boom",))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        b"\x81",
        packed({"a": 1})[:-1],
        packed({"a": 1}) + b"\x00",
        msgpack.packb({b"nd": True, b"type": "|O", b"shape": [1], b"data": pickle.dumps([Boom()])}),
        msgpack.packb({b"nd": True, b"type": "<f8", b"shape": [7], b"data": b"12345678"}),
        msgpack.packb({b"nd": True, b"type": "nonsense", b"shape": [1], b"data": b"12345678"}),
        msgpack.packb({b"nd": True, b"shape": [1], b"data": b"12345678"}),
    ],
)
def test_what_is_no_message_is_refused(data, capsys):
    with pytest.raises(ValueError, match="not a MessagePack message"):
        unpacked(data)
    assert capsys.readouterr().out == ""


def test_what_cannot_be_sent_is_refused():
    with pytest.raises(TypeError, match="BytesIO cannot be sent"):
        packed(io.BytesIO())


def test_a_question_has_what_the_detector_observes_and_nothing_else(observation):
    gripper = GRIPPERS["panda"]
    for name in ("view", "views", "tsdf", "cloud", "object_clouds"):
        asked = unpacked(packed(question(observation, name, gripper, 7)))
        assert list(asked["observation"]) == [name]
        assert asked["seed"] == 7
        assert asked["gripper"]["opening"] == gripper.opening
    (own,) = asked["observation"]["object_clouds"]
    assert own["points"].tolist() == observation.object_clouds[0].points.tolist()
    assert own["normals"].tolist() == observation.object_clouds[0].normals.tolist()
    everything = unpacked(packed(question(observation, "observation", gripper, 7)))["observation"]
    assert set(everything) == {"view", "views", "tsdf", "cloud"}
    assert len(everything["views"]) == len(observation.views)
    for sent, view in zip(everything["views"], observation.views, strict=True):
        assert sent["depth"].tobytes() == view.depth.tobytes()
        assert sent["pose"].tolist() == view.pose.tolist()
    assert everything["cloud"]["points"].tolist() == observation.cloud.points.tolist()
    assert everything["tsdf"]["distances"].shape == (40, 40, 40)
    assert everything["tsdf"]["voxel"] == observation.tsdf.voxel


def test_the_camera_matrix_takes_points_to_their_pixels(observation):
    view = observation.view
    sent = question(view, "view", GRIPPERS["panda"], 0)["observation"]["view"]
    points = view.points()
    camera = np.linalg.inv(view.pose)
    for row, column in ((10, 20), (30, 5), (40, 55)):
        local = camera[:3, :3] @ points[row, column] + camera[:3, 3]
        u, v, w = sent["intrinsics"] @ local
        assert (u / w, v / w) == pytest.approx((column, row), abs=1e-6)


def test_answers_are_poses_or_grasps_from_above():
    poses = np.stack([np.eye(4)] * 3)
    found = answered({"poses": poses, "widths": np.zeros(3), "scores": [1, 2, 3]})
    assert isinstance(found, GraspPoses)
    assert found.scores.tolist() == [1, 2, 3]
    assert len(answered({"poses": [], "widths": [], "scores": []}).poses) == 0
    columns = {"center": [[1, 2, 3]], "angle": [4], "width": [5], "depth": [6], "quality": [7]}
    assert answered({"grasps": columns}) == [Grasp((1, 2, 3), 4, 5, 6, 7)]
    assert answered({"grasps": {name: [] for name in columns}}) == []


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ([1, 2], "must be a map, got list"),
        ({}, "no 'poses'"),
        ({"error": "out of memory"}, "it says: out of memory"),
        ({"poses": np.eye(4), "widths": [1], "scores": [1]}, "must be"),
        ({"poses": np.eye(4)[None], "widths": [1, 2], "scores": [1]}, "must be"),
        ({"grasps": {"center": [[1, 2, 3]]}}, "no 'angle'"),
    ],
)
def test_what_is_no_answer_is_refused(message, said):
    with pytest.raises((ValueError, TypeError), match=said):
        answered(message)
