"""Detectors are found by their names, and what users bring cannot break a run."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.detectors import DETECTORS, DetectorConfig
from egad.detectors.base import Grasp
from egad.detectors.parameters import SHIPPED_NETWORKS
from egad.detectors.registry import QUICK, fingerprint, make_detector
from egad.detectors.subprocess import Child, DetectorError, DetectorTimeoutError
from egad.errors import UserError
from egad.grippers import GRIPPERS

HAND = GRIPPERS["egad_75mm"]
CODE = """
import os, signal, time
import numpy as np
from collections import namedtuple
from egad.detectors.base import Grasp

Mine = namedtuple("Mine", "center angle width depth quality")
MIDDLE = Mine((0, 0, 0.02), 0.0, 0.05, 0.01, 1)

class Middle:
    def __call__(self, view, gripper, rng): return [MIDDLE]
class Weighted:
    def __init__(self, path): self.width = float(open(path).read())
    def __call__(self, view, gripper, rng): return [Grasp((0, 0, 0.02), 0.0, self.width, 0.01, 1)]
class Chancy:
    def __call__(self, view, gripper, rng): return [MIDDLE._replace(angle=rng.random())]
class Sees:
    def __call__(self, view, gripper, rng): return [MIDDLE._replace(quality=view.depth.min())]
class Broken:
    def __init__(self): raise OSError("no such camera")
class NotCallable: pass
def raises(view, gripper, rng): raise ValueError("no idea")
def gives_text(view, gripper, rng): return ["grasp"]
def gives_nothing(view, gripper, rng): return None
def finds_nothing(view, gripper, rng): return []
def finds_no_tuple(view, gripper, rng): return ()
def leaves(view, gripper, rng): os._exit(7)
def killed(view, gripper, rng): os.kill(os.getpid(), signal.SIGKILL)
def greedy(view, gripper, rng): return np.ones(1 << 50)
def sleeps(view, gripper, rng):
    if view.depth.max() > 0.5: time.sleep(600)
    return [MIDDLE]
number = 3
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "mine.py"
    path.write_text(CODE)
    return path


@pytest.fixture(scope="module")
def view(look):
    return look(trimesh.creation.box((0.03, 0.06, 0.04)))


def asked(detect, view, seed=0):
    return detect(view, HAND, np.random.default_rng(seed))


def test_any_object_with_the_numbers_of_a_grasp_will_do(file, view):
    found = asked(make_detector(DetectorConfig(detector=f"{file}:Middle")), view)
    assert found == [Grasp((0.0, 0.0, 0.02), 0.0, 0.05, 0.01, 1.0)]


def test_a_function_or_a_package_will_do(file, view):
    for name in ("finds_nothing", "finds_no_tuple"):
        assert asked(make_detector(DetectorConfig(detector=f"{file}:{name}")), view) == []
    packaged = make_detector(DetectorConfig(detector="egad.detectors.antipodal:antipodal_depth"))
    assert asked(packaged, view) == asked(QUICK["antipodal-depth"], view)


def test_weights_go_to_the_class(file, view, tmp_path):
    weights = tmp_path / "weights.txt"
    weights.write_text("0.033")
    detector = DetectorConfig(detector=f"{file}:Weighted", weights=str(weights))
    assert asked(make_detector(detector), view)[0].width == 0.033


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("{file}:Missing", "no class or function Missing"),
        ("nowhere.py:Middle", "no such file or module"),
        ("{file}:Broken", "cannot be made: OSError: no such camera"),
        ("{file}:Weighted", "cannot be made: TypeError"),
    ],
)
def test_a_detector_that_cannot_be_made_is_the_users_mistake(file, name, words):
    detector = DetectorConfig(detector=name.format(file=file))
    with pytest.raises(UserError, match=words):
        make_detector(detector)


def test_weights_for_a_function_are_a_mistake(file):
    with pytest.raises(UserError, match="is not a class that takes `weights`"):
        make_detector(DetectorConfig(detector=f"{file}:raises", weights="w"))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"detector": "telepathy"}, "labels, random, suction-cloud, suction-depth, vgn, graspgen"),
        ({"detector": "telepathy"}, "vgn, graspgen, FILE.py:CLASS"),
        ({"detector": "random", "weights": "w.pt"}, "takes no `weights`"),
        ({"detector": "grasps:"}, "'grasps:'; allowed: .*grasps:FILE or grasps:FOLDER"),
        ({"detector": "grasps:a.h5", "weights": "w"}, "grasps:a.h5 takes no `weights`"),
        ({"detector": "ggcnn", "avoid_collisions": True}, "ggcnn takes no `avoid_collisions`"),
    ],
)
def test_what_no_detector_can_be_is_refused(values, words):
    with pytest.raises(ValueError, match=words):
        DetectorConfig(**values)


def test_known_grasps_need_the_pose_of_the_object():
    known = DetectorConfig(detector="grasps:~/a.h5")
    assert known.known_grasps == Path.home() / "a.h5"
    assert DetectorConfig(detector="my/grasps:9.py:Own").known_grasps is None
    assert fingerprint(known) == []
    with pytest.raises(UserError, match=r"grasps:~/a.h5 knows where the object is"):
        make_detector(known)


def test_edited_code_or_weights_have_another_fingerprint(tmp_path):
    code, weights = tmp_path / "mine.py", tmp_path / "w"
    code.write_text(CODE)
    weights.write_text("1")
    detector = DetectorConfig(detector=f"{code}:Weighted", weights=str(weights))
    before = fingerprint(detector)
    code.write_text(CODE + "\n")
    edited = fingerprint(detector)
    weights.write_text("2")
    assert len({tuple(before), tuple(edited), tuple(fingerprint(detector))}) == 3
    assert fingerprint(DETECTORS["random"]) == []
    for name, settings in SHIPPED_NETWORKS.items():
        assert fingerprint(DETECTORS[name]) == fingerprint(DetectorConfig(**settings)) != []
        assert fingerprint(DetectorConfig(command=(name,))) == []


def test_a_child_answers_as_the_detector_itself(file, view):
    for name in ("Chancy", "Sees"):
        detector = DetectorConfig(detector=f"{file}:{name}")
        with Child(detector, 60) as child:
            for seed in (1, 2):
                assert asked(child, view, seed) == asked(make_detector(detector), view, seed)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("raises", r"mine.py\", line \d+, in raises(.|\n)*\nValueError: no idea"),
        ("gives_text", r"gives_text .*mine.py, line 23\) must return .* list \['grasp'\]"),
        ("gives_nothing", r"gives_nothing .*mine.py, line 24\) must .* NoneType None"),
    ],
)
def test_errors_in_a_child_are_told_and_it_goes_on(file, view, name, words):
    with Child(DetectorConfig(detector=f"{file}:{name}"), 60) as child:
        for _ in range(2):
            with pytest.raises(DetectorError, match=words):
                asked(child, view)


def test_a_child_that_dies_is_started_anew(file, view):
    with Child(DetectorConfig(detector=f"{file}:leaves"), 60) as child:
        for _ in range(2):
            with pytest.raises(DetectorError, match="ended with status 7"):
                asked(child, view)


@pytest.mark.parametrize(
    ("name", "error", "words"),
    [
        ("killed", UserError, "the detector .*:killed was killed, probably out of memory"),
        ("greedy", MemoryError, "Unable to allocate"),
    ],
)
def test_want_of_memory_is_no_outcome_of_an_attempt(file, view, name, error, words):
    with (
        pytest.raises(error, match=words),
        Child(DetectorConfig(detector=f"{file}:{name}"), 60) as child,
    ):
        asked(child, view)


def test_a_child_that_takes_too_long_is_stopped_and_started_anew(file, view):
    near = type(view)(view.depth * 0.1, view.intrinsics, view.pose)
    with Child(DetectorConfig(detector=f"{file}:sleeps"), 1.0) as child:
        with pytest.raises(DetectorTimeoutError, match="did not answer within 1 s"):
            asked(child, view)
        assert len(asked(child, near)) == 1


def test_what_cannot_be_started_anew_is_an_error_of_the_attempt(view, tmp_path):
    """The file is removed while the detector works: what runs goes on, and fails alone."""
    path = tmp_path / "fleeting.py"
    path.write_text(CODE)
    with Child(DetectorConfig(detector=f"{path}:leaves"), 60) as child:
        path.unlink()
        with pytest.raises(DetectorError, match="ended with status 7"):
            asked(child, view)
        for _ in range(2):
            with pytest.raises(DetectorError, match=r"cannot be restarted: .*no such file"):
                asked(child, view)


def test_a_child_that_cannot_be_made_at_its_first_question_is_the_users_mistake(file, view):
    child = Child(DetectorConfig(detector=f"{file}:Broken"), 60)
    for _ in range(2):
        with pytest.raises(UserError, match="no such camera"):
            asked(child, view)


def test_a_command_is_instead_of_a_detector_and_its_files_count(tmp_path):
    with pytest.raises(ValueError, match="either `detector` or `command`"):
        DetectorConfig()
    with pytest.raises(ValueError, match="either `detector` or `command`"):
        DetectorConfig(detector="random", command=("python", "mine.py"))
    with pytest.raises(ValueError, match="takes no `weights`"):
        DetectorConfig(command=("python", "mine.py"), weights="w.pt")
    path = tmp_path / "mine.py"
    path.write_text("1")
    config = DetectorConfig(command=("python", str(path), "--fast"))
    first = fingerprint(config)
    path.write_text("2")
    assert len(first) == 1
    assert first != fingerprint(config)


def test_what_asks_for_more_than_a_view_cannot_do_trials(tmp_path, view):
    path = tmp_path / "mine.py"
    path.write_text("def of_a_cloud(cloud, gripper, rng): return []\n")
    config = DetectorConfig(detector=f"{path}:of_a_cloud")
    with Child(config, 60) as child, pytest.raises(UserError, match="egad benchmark"):
        child(view, HAND, np.random.default_rng(0))
