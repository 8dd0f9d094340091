"""GraspGen's messages, spoken by a stand-in for its server."""

import threading

import msgpack
import numpy as np
import pytest

from egad.detectors import DetectorConfig, choose, opened
from egad.detectors import graspgen as module
from egad.detectors.base import DetectorError
from egad.detectors.graspgen import GraspGen
from egad.detectors.observation import PointCloud
from egad.errors import UserError
from egad.grippers import GRIPPERS

zmq = pytest.importorskip("zmq")
HAND = GRIPPERS["panda"]


def encoded(array):
    """As msgpack-numpy does."""
    data = {b"type": array.dtype.str, b"kind": b"", b"shape": array.shape, b"data": array.tobytes()}
    return {b"nd": True, **data}


class Server(threading.Thread):
    """Answers as GraspGen's server does: grasps around the mean of the points it got."""

    def __init__(self, gripper="franka_panda", count=3, fails=False, rising=False):
        super().__init__(daemon=True)
        self.gripper, self.count, self.fails, self.requests = gripper, count, fails, []
        self.rising = rising  # whether later answers have higher scores
        self.socket = zmq.Context.instance().socket(zmq.REP)
        port = self.socket.bind_to_random_port("tcp://127.0.0.1")
        self.address = f"tcp://127.0.0.1:{port}"

    def run(self):
        while True:
            request = msgpack.unpackb(self.socket.recv())
            self.requests.append(request)
            if request["action"] == "end":
                self.socket.send(b"")
                self.socket.close()
                return
            self.socket.send(msgpack.packb(self.answer(request)))

    def answer(self, request):
        if request["action"] == "metadata":
            return {"gripper_name": self.gripper, "model_name": "m", "gripper_config": "c.yml"}
        if self.fails:
            return {"error": "CUDA out of memory"}
        sent = request["point_cloud"]
        points = np.frombuffer(sent[b"data"], sent[b"type"]).reshape(sent[b"shape"])
        grasps = np.tile(np.diag([1, -1, -1, 1]).astype(np.float32), (self.count, 1, 1))
        grasps[:, :3, 3] = points.mean(axis=0)
        scores = np.linspace(0.1, 0.9, self.count, dtype=np.float32)
        scores += self.rising * (len(self.requests) - 2)
        found = {"grasps": encoded(grasps), "confidences": encoded(scores)}
        return found | {"num_grasps": self.count, "timing": {"infer_ms": 1.0}}


@pytest.fixture
def serve():
    """A running stand-in."""
    started = []

    def start(**how):
        server = Server(**how)
        server.start()
        started.append(server)
        return server

    yield start
    for server in started:
        with zmq.Context.instance().socket(zmq.REQ) as end:
            end.connect(server.address)
            end.send(msgpack.packb({"action": "end"}))
            end.recv()
        server.join()


def cloud_of(count, center=(0.1, 0.2, 0.3)):
    points = np.random.default_rng(0).normal(center, 0.01, (count, 3))
    return PointCloud(points, np.zeros_like(points))


def test_grasps_are_moved_from_the_base_of_the_gripper_to_between_its_pads(serve):
    server, cloud = serve(), cloud_of(500)
    found = GraspGen(server.address)([cloud], HAND, np.random.default_rng(0))
    assert found.poses.shape == (3, 4, 4)
    np.testing.assert_allclose(found.widths, HAND.opening)
    np.testing.assert_allclose(found.scores, [0.1, 0.5, 0.9], rtol=1e-6)
    # the hand comes from above, so its pads are that much lower than its base
    mean = cloud.points.astype(np.float32).mean(axis=0)
    np.testing.assert_allclose(found.poses[:, :3, 3], [mean - [0, 0, 0.1053]] * 3, atol=1e-6)
    np.testing.assert_array_equal(found.poses[:, :3, :3], [np.diag([1, -1, -1])] * 3)
    asked = server.requests[1]
    assert asked["action"] == "infer"
    assert asked["point_cloud"][b"type"] == "<f4"
    assert asked["point_cloud"][b"shape"] == [500, 3]


def test_each_object_is_asked_about_alone_and_the_grasps_of_all_are_given(serve):
    """The second object gets higher scores, so the best grasp is on it."""
    server, clouds = serve(rising=True), [cloud_of(500), cloud_of(300, (0.0, -0.1, 0.2))]
    found = GraspGen(server.address)(clouds, HAND, None)
    sent = [each["point_cloud"][b"shape"] for each in server.requests[1:]]
    assert sent == [[500, 3], [300, 3]]
    np.testing.assert_allclose(found.scores, [0.1, 0.5, 0.9, 1.1, 1.5, 1.9], rtol=1e-6)
    best = choose(found, HAND)
    mean = clouds[1].points.mean(axis=0)
    np.testing.assert_allclose(best.pose[:3, 3], mean - [0, 0, 0.1053], atol=1e-6)


def test_clouds_that_are_too_small_for_the_server_are_not_sent(serve):
    server = serve()
    detect = GraspGen(server.address)
    assert len(detect([cloud_of(0), cloud_of(20)], HAND, None).poses) == 0
    assert len(detect([], HAND, None).poses) == 0
    assert [each["action"] for each in server.requests] == ["metadata"]
    assert len(detect([cloud_of(20), cloud_of(21)], HAND, None).poses) == 3
    assert len(server.requests) == 2


def test_no_grasps_are_no_error(serve):
    assert len(GraspGen(serve(count=0).address)([cloud_of(30)], HAND, None).poses) == 0


def test_an_error_of_the_server_is_one_of_the_attempt(serve, observation):
    config = DetectorConfig(detector="graspgen", address=serve(fails=True).address)
    with opened(config, 60) as detect, pytest.raises(DetectorError, match="CUDA out of memory"):
        detect(observation, HAND, np.random.default_rng(0))


def test_a_server_of_another_gripper_is_refused(serve):
    with pytest.raises(UserError, match="single_suction_cup_30mm; known: franka_panda"):
        GraspGen(serve(gripper="single_suction_cup_30mm").address)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense"])
def test_where_no_server_answers_is_named(monkeypatch, address):
    monkeypatch.setattr(module, "GREETING_TIME", 200)
    with pytest.raises(UserError, match=f"no GraspGen server at {address}"):
        GraspGen(address)


@pytest.mark.parametrize(
    "values",
    [{"detector": "graspgen"}, {"detector": "random", "address": "tcp://localhost:5556"}],
)
def test_graspgen_alone_has_an_address(values):
    with pytest.raises(ValueError, match="graspgen needs `address`"):
        DetectorConfig(**values)
