"""Detectors in programs of their own, good and bad ones."""

import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
import trimesh

import egad
from egad.detectors import DetectorConfig
from egad.detectors.base import DetectorError, DetectorTimeoutError
from egad.detectors.program import Program
from egad.errors import UserError
from egad.grippers import GRIPPERS

EXAMPLE = Path(__file__).parents[2] / "examples/detector_program.py"
HEAD = """
import os, struct, sys, time
import msgpack
import numpy as np
def send(message):
    data = msgpack.packb(message)
    os.write(1, struct.pack(">I", len(data)) + data)
def ask():
    head = sys.stdin.buffer.read(4)
    if len(head) < 4:
        sys.exit(0)
    return sys.stdin.buffer.read(struct.unpack(">I", head)[0])
def answer(poses, width=0.05):
    count = len(poses)
    send({"poses": poses, "widths": [width] * count, "scores": [1.0] * count})
HELLO = {"protocol": 1, "observes": "cloud"}
"""
DOWN = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.05], [0, 0, 0, 1]]
# Seconds: for what must work on a slow machine; to start; to answer.
PATIENT, IMPATIENT, HASTY = 60.0, 1.0, 0.2


@pytest.fixture
def program(tmp_path):
    """From code to a command; it is killed at the end if it is still there."""

    def made(code):
        path = tmp_path / "program.py"
        path.write_text(HEAD + textwrap.dedent(code))
        return [sys.executable, str(path)]

    yield made
    for process in psutil.Process().children(recursive=True):
        if str(tmp_path) in " ".join(process.cmdline()):
            process.kill()
            pytest.fail("the program was left behind")


def ask(detect, observation, seed=0):
    return detect(observation, GRIPPERS["panda"], np.random.default_rng(seed))


def test_the_example_answers_as_its_function_does(observation):
    space = {"__name__": "example"}
    exec(EXAMPLE.read_text(), space)  # noqa: S102
    cloud = {"points": observation.cloud.points, "normals": observation.cloud.normals}
    gripper = GRIPPERS["panda"]
    with Program([sys.executable, str(EXAMPLE)], PATIENT, PATIENT) as detect:
        for _ in range(2):
            rng = np.random.default_rng(int(np.random.default_rng(0).integers(2**63)))
            expected = space["detect"]({"cloud": cloud}, gripper.model_dump(), rng)
            assert len(expected[0]) > 10
            for found, values in zip(ask(detect, observation), expected, strict=True):
                assert found.tobytes() == np.asarray(values).tobytes()


def test_the_example_clears_tables_without_egad(tmp_path):
    """Its Python cannot import egad."""
    path = tmp_path / "isolated.py"
    path.write_text(f"import sys; sys.modules['egad'] = None\n{EXAMPLE.read_text()}")
    config = DetectorConfig(command=(sys.executable, str(path)))
    boxes = {"box": trimesh.creation.box((0.03, 0.04, 0.05))}
    few = {"rounds": 2, "rule": "none", "scenes": ["single"], "noise": ["none"]}
    found = egad.run_benchmark(config, boxes, **few)
    assert found.rates()[0].success.successes == 2
    assert found.table.equals(egad.run_benchmark(config, boxes, jobs=2, **few).table)


def test_the_seed_is_from_the_generator(observation, program):
    command = program("""
        send(HELLO)
        while True:
            seed = msgpack.unpackb(ask())["seed"]
            answer([np.eye(4).tolist()], width=seed / 2**63)
    """)
    with Program(command, PATIENT, PATIENT) as detect:
        first, again, other = (ask(detect, observation, seed).widths for seed in (1, 1, 2))
    assert first == again != other


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("sys.exit(3)", "ended with status 3"),
        ("send({'protocol': 2, 'observes': 'cloud'})", "must begin with"),
        ("os.write(1, struct.pack('>I', 3) + b'\\xc1\\xc1\\xc1'); time.sleep(60)", "not a Message"),
        ("os.write(1, b'\\0\\0\\0\\1\\1surplus'); time.sleep(60)", "more than one message"),
        ("time.sleep(60)", "did not answer"),
    ],
)
def test_a_program_that_does_not_start_is_a_mistake_of_the_user(program, code, said):
    limit = IMPATIENT if said == "did not answer" else PATIENT
    with pytest.raises(UserError, match=f"cannot be started: .*{said}"):
        Program(program(code), PATIENT, limit).__enter__()


def test_a_program_that_is_not_there_is_named(tmp_path):
    with pytest.raises(UserError, match=r"nowhere cannot be started: .*No such file"):
        Program([str(tmp_path / "nowhere")], PATIENT, PATIENT).__enter__()


@pytest.mark.parametrize(
    ("code", "error"),
    [
        ("time.sleep(60)", DetectorTimeoutError),
        ("os.write(1, b'\\0\\0\\0\\x08half'); time.sleep(60)", DetectorTimeoutError),
        ("os.kill(os.getpid(), 11)", DetectorError),
        ("os.write(1, struct.pack('>I', 1) + b'\\xc1')", DetectorError),
        ("send([1, 2, 3])", DetectorError),
        ("send({'error': 'no idea'})", DetectorError),
        ("send({'poses': [], 'widths': [1.0], 'scores': []})", DetectorError),
    ],
)
def test_what_goes_wrong_in_an_attempt_is_told_and_the_next_one_works(
    observation, program, tmp_path, monkeypatch, code, error
):
    """Only the first question ever is answered wrongly."""
    monkeypatch.setattr("egad.detectors.program.ENDING_TIME", 0.5)
    mark = str(tmp_path / "mark")
    command = program(f"""
        send(HELLO)
        while True:
            ask()
            if not os.path.exists({mark!r}):
                open({mark!r}, "w").close()
                {code}
            else:
                answer([{DOWN}])
    """)
    limit = HASTY if error is DetectorTimeoutError else PATIENT
    with Program(command, limit, PATIENT) as detect:
        with pytest.raises(error):
            ask(detect, observation)
        detect._limit = PATIENT
        assert ask(detect, observation).poses.tolist() == [DOWN]


def test_a_program_that_never_reads_does_not_stop_everything(observation, program):
    with Program(program("send(HELLO); time.sleep(60)"), HASTY, PATIENT) as detect:
        begin = time.monotonic()
        with pytest.raises(DetectorTimeoutError):
            ask(detect, observation)
        assert time.monotonic() - begin < 30


def test_a_program_that_cannot_be_started_again_fails_its_attempts(observation, program):
    command = program("send(HELLO); ask(); sys.exit(1)")
    with Program(command, PATIENT, PATIENT) as detect:
        with pytest.raises(DetectorError, match="ended with status 1"):
            ask(detect, observation)
        Path(command[1]).unlink()
        with pytest.raises(DetectorError, match="cannot be started"):
            ask(detect, observation)


ABANDONS = """
import os, signal, sys
from egad.detectors.program import Program

with Program(sys.argv[1:], 60, 60):
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_stubborn_program_and_what_it_started_end_when_egad_is_killed(program, tmp_path):
    file = tmp_path / "pids"
    command = program(f"""
        import signal
        import subprocess
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        child = subprocess.Popen(["sleep", "600"])
        open({str(file)!r}, "w").write(f"{{os.getpid()}} {{child.pid}}")
        send(HELLO)
        while True:
            pass
    """)
    killed = subprocess.run([sys.executable, "-c", ABANDONS, *command], check=False)
    assert killed.returncode == -signal.SIGKILL
    pids = map(int, file.read_text().split())
    left = [psutil.Process(pid) for pid in pids if psutil.pid_exists(pid)]
    assert not psutil.wait_procs(left, timeout=5)[1]


def test_trials_give_a_view_and_nothing_else(observation, program):
    view = observation.view
    wants_cloud = Program(program("send(HELLO); ask()"), PATIENT, PATIENT)
    with wants_cloud as detect, pytest.raises(UserError, match="egad benchmark"):
        ask(detect, view)
    command = program("""
        HELLO["observes"] = "view"
        send(HELLO)
        asked = msgpack.unpackb(ask())["observation"]
        count = len(asked["view"][b"depth" if b"depth" in asked["view"] else "depth"])
        send({"grasps": {"center": [[0, 0, 0.02]], "angle": [0.5], "width": [0.04],
                         "depth": [0.01], "quality": [float(count > 0)]}})
    """)
    with Program(command, PATIENT, PATIENT) as detect:
        assert ask(detect, view)[0].quality == 1


@pytest.mark.parametrize(
    ("height", "said"),
    [("0.55", "in the frame of a camera"), ("float('nan')", "not_finite")],
)
def test_a_program_with_useless_poses_is_told(program, caplog, height, said):
    command = program(f"""
        send(HELLO)
        while True:
            ask()
            answer([[[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, {height}], [0, 0, 0, 1]]])
    """)
    boxes = {"box": trimesh.creation.box((0.03, 0.04, 0.05))}
    few = {"rounds": 3, "rule": "none", "scenes": ["single"], "noise": ["none"]}
    detect = DetectorConfig(command=tuple(command))
    if said == "not_finite":
        assert set(egad.run_benchmark(detect, boxes, **few).table["outcome"]) == {said}
        return
    with pytest.raises(UserError, match="failed in all"):
        egad.run_benchmark(detect, boxes, **few)
    assert said in caplog.text
