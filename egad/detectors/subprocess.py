"""A detector in a process of its own: it can be stopped, and what it breaks is only its own."""

from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Self

import numpy as np

from egad._util.workers import ANEW, ENDING_TIME, check_not_killed
from egad.detectors.base import Detector, Grasp
from egad.detectors.parameters import Policy
from egad.detectors.registry import detector
from egad.errors import UserError
from egad.grasps.gripper import Gripper
from egad.perception.camera import View

STARTING_TIME = 300.0  # seconds; large libraries and weights take a while to load

Question = tuple[View, Gripper, np.random.Generator]


class DetectorError(Exception):
    """A detector raised an error, gave something else than grasps, or ended its process."""


class DetectorTimeoutError(Exception):
    """A detector took too long and was stopped."""


class Child:
    """A detector that answers from another process, started anew whenever it had to be stopped."""

    def __init__(self, policy: Policy, limit: float) -> None:
        """Prepare; the process starts with the first question, or with the `with` block.

        Args:
            policy: The detector.
            limit: Seconds that an answer may take.
        """
        self._policy = policy
        self._limit = limit
        self._process: BaseProcess | None = None
        self._was_ready = False

    def __enter__(self) -> Self:
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def __call__(self, view: View, gripper: Gripper, rng: np.random.Generator) -> list[Grasp]:
        """Ask the detector.

        Raises:
            DetectorError: It failed, or cannot be started anew.
            DetectorTimeoutError: It was stopped.
            MemoryError: It had not enough.
            UserError: It cannot be made the first time, or its process was killed.
        """
        if self._process is None:
            self._restart()
        try:
            self._pipe.send((view, gripper, rng))
            if not self._pipe.poll(self._limit):
                self._stop()
                raise DetectorTimeoutError(f"no answer within {self._limit:g} s")
            kind, answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise DetectorError(self._end()) from error
        if kind == "memory":
            raise MemoryError(answer)
        if kind == "error":
            raise DetectorError(answer)
        grasps: list[Grasp] = answer
        return grasps

    def _restart(self) -> None:
        """Start; if that has worked before, it is no mistake of the user that it fails now."""
        try:
            self._start()
        except UserError as error:
            if self._was_ready:
                raise DetectorError(f"it cannot be started anew: {error}") from error
            raise

    def _start(self) -> None:
        self._pipe, theirs = ANEW.Pipe()
        self._process = ANEW.Process(target=_serve, args=(theirs, self._policy), daemon=True)
        self._process.start()
        theirs.close()
        name = self._policy.detector
        try:
            if not self._pipe.poll(STARTING_TIME):
                self._stop()
                raise UserError(f"{name} was not ready within {STARTING_TIME:g} s")
            kind, problem = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise UserError(f"{name} cannot be made: {self._end()}") from error
        if kind == "error":
            self._stop()
            raise UserError(problem)
        self._was_ready = True

    def _end(self) -> str:
        """How a process ended that does not answer any more, in words.

        Raises:
            UserError: It was killed.
        """
        status = self._stop()
        check_not_killed(status, f"the process of the detector {self._policy.detector}")
        ended = "hung up" if status is None else f"ended with status {status}"
        return f"its process {ended}"

    def _stop(self) -> int | None:
        """End the process; its status if it had ended by itself."""
        process, self._process = self._process, None
        if process is None:
            return None
        self._pipe.close()  # it ends by itself when nobody can ask any more
        process.join(0.2)
        alone = not process.is_alive()
        if not alone:
            process.kill()
        process.join(ENDING_TIME)
        return process.exitcode if alone else None


def _serve(pipe: Connection, policy: Policy) -> None:
    """Make the detector and answer until the other end of the pipe closes."""
    try:
        detect = detector(policy)
    except UserError as error:
        pipe.send(("error", str(error)))
        return
    pipe.send(("ready", ""))
    while True:
        try:
            question = pipe.recv()
        except EOFError:
            return
        pipe.send(_answer(detect, question))


def _answer(detect: Detector, question: Question) -> tuple[str, list[Grasp] | str]:
    try:
        return "grasps", detect(*question)
    except MemoryError as error:
        return "memory", str(error)
    except Exception as error:
        return "error", f"{type(error).__name__}: {error}"
