"""Detectors for as long as they are used, most of them in a process of their own.

There they can be stopped, and can break only their own process.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any, Self, TypeAlias

import numpy as np

from egad._util.child_process import Worker, WorkerDiedError, WorkerTimeoutError
from egad.detectors.asking import Detector, check_views_will_do, seen_by, wanted_input
from egad.detectors.base import DetectorError, DetectorTimeoutError, Grasp, GraspPoses
from egad.detectors.camera import View
from egad.detectors.failures import failure_text
from egad.detectors.observation import Observation
from egad.detectors.parameters import DetectorConfig
from egad.detectors.program import Program
from egad.detectors.registry import IN_SCENES, make_detector, with_checked_answers
from egad.errors import UserError, check_name
from egad.grippers import Gripper

Detect: TypeAlias = Callable[..., Any] | DetectorConfig
STARTING_TIME = 300.0  # seconds; large libraries and weights take a while to load

Question = tuple[View | Observation, Gripper, np.random.Generator]
Answer = list[Grasp] | GraspPoses | MemoryError | str  # text: what went wrong, with a traceback


class Child:
    """A detector that answers from another process, restarted whenever it had to be stopped."""

    def __init__(self, config: DetectorConfig, limit: float) -> None:
        """Prepare; the process starts with the first question or `with` block. Limit: seconds."""
        name = f"the process of the detector {config.name}"
        self._worker = Worker(partial(_answering, config), limit, STARTING_TIME, name)
        self._was_ready = False

    def __enter__(self) -> Self:
        self._start()
        return self

    def __exit__(self, *error: object) -> None:
        self._worker.__exit__(*error)

    def __call__(
        self, observation: View | Observation, gripper: Gripper, rng: np.random.Generator
    ) -> list[Grasp] | GraspPoses:
        """Ask the detector, which gets the part of an observation that it wants."""
        if not self._worker.running:
            self._start()
        try:
            answer: Answer = self._worker((observation, gripper, rng))
        except WorkerTimeoutError as error:
            raise DetectorTimeoutError(str(error)) from error
        except WorkerDiedError as error:
            raise DetectorError(str(error)) from error
        if isinstance(answer, str):
            raise DetectorError(answer)
        if isinstance(answer, MemoryError):
            raise answer
        return answer

    @property
    def wants(self) -> str:
        """What the detector wants to see: one of `INPUTS`."""
        if not self._worker.running:
            self._start()
        answer = self._worker(None)
        return str(answer)

    def _start(self) -> None:
        """Start; if that has worked before, a failure now is not a mistake of the user."""
        try:
            self._worker.start()
        except UserError as error:
            if self._was_ready:
                raise DetectorError(f"it cannot be restarted: {error}") from error
            raise
        self._was_ready = True


def as_detector(detect: Detect | str, names: Iterable[str]) -> Detect:
    """A detector, also by one of these names; UserError if it is none."""
    if isinstance(detect, str):
        return DetectorConfig(detector=check_name("detector", detect, names))
    if not isinstance(detect, DetectorConfig) and not callable(detect):
        raise UserError(f"a detector is a function or the name of one, got {detect!r}")
    return detect


@contextmanager
def opened(detect: Detect, limit: float, *, at_once: bool = True) -> Iterator[Detector]:
    """A detector, in a process of its own if need be, that has `limit` seconds for an answer."""
    if not isinstance(detect, DetectorConfig):
        yield with_checked_answers(detect)
    elif detect.detector in IN_SCENES:
        yield IN_SCENES[detect.detector]
    else:
        program = detect.command
        made = Program(program, limit, STARTING_TIME) if program else Child(detect, limit)
        with ExitStack() as stack:
            (stack.enter_context if at_once else stack.push)(made)
            yield made


def asked_for(detect: Detector) -> str:
    """What a detector wants to see, one of `INPUTS`: also one in a process of its own."""
    return detect.wants if isinstance(detect, Child | Program) else wanted_input(detect)


@contextmanager
def _answering(config: DetectorConfig) -> Iterator[Callable[[Question | None], Answer]]:
    """Make the detector, in its own process."""
    detect = make_detector(config)
    wanted_input(detect)
    yield partial(_answer, detect)


def _answer(detect: Detector, question: Question | None) -> Answer:
    """The answer to a question; without one, what the detector wants to see."""
    if question is None:
        return wanted_input(detect)
    seen, gripper, rng = question
    if not isinstance(seen, Observation):
        check_views_will_do(detect)
    try:
        if isinstance(seen, Observation):
            return detect(seen_by(detect, seen), gripper, rng)
        return detect(seen, gripper, rng)
    except MemoryError as error:
        return MemoryError(str(error))
    except Exception as error:
        return failure_text(error)
