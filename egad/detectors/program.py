"""A detector that is a separate program, asked through its standard input and output.

A message is its length in four bytes, the highest byte first, and then MessagePack
(`egad.detectors.messages`). docs/detectors.md describes the conversation.
"""

import contextlib
import multiprocessing
import os
import selectors
import signal
import struct
import subprocess
import time
from collections.abc import Sequence
from typing import Any, Self

import numpy as np

from egad._util.child_process import kill_when_closed
from egad.detectors.asking import INPUTS, more_than_a_view
from egad.detectors.base import WHERE, Answer, DetectorError, DetectorTimeoutError
from egad.detectors.camera import View
from egad.detectors.messages import PROTOCOL, answered, packed, question, unpacked
from egad.detectors.observation import Observation
from egad.errors import UserError
from egad.grippers import Gripper

LENGTH = struct.Struct(">I")
MAX_BYTES = 1 << 28  # bytes of an answer
PIECE = 1 << 16  # bytes that are read or written at once
ENDING_TIME = 2.0  # seconds


class Program:
    """A detector in a program, which is restarted whenever it had to be stopped."""

    def __init__(self, command: Sequence[str], limit: float, starting_limit: float) -> None:
        """Prepare; the program starts with the first question or `with` block. Limits: seconds."""
        self._command, self._limit, self._starting_limit = list(command), limit, starting_limit
        self._name = f"the program {' '.join(command)}"
        self._process: subprocess.Popen[bytes] | None = None
        self._was_ready = False
        self._wants = ""

    def __enter__(self) -> Self:
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop(ENDING_TIME)

    def __call__(
        self, observation: Observation | View, gripper: Gripper, rng: np.random.Generator
    ) -> Answer:
        """Ask the detector, which gets the part of an observation that it wants."""
        if self._process is None:
            self._start()
        if isinstance(observation, View) and self._wants != "view":
            raise more_than_a_view(self._name, self._wants)
        seed = int(rng.integers(2**63))
        message = packed(question(observation, self._wants, gripper, seed))
        answer = self._exchange(message, self._limit)
        try:
            return answered(answer)
        except (ValueError, TypeError) as error:
            raise DetectorError(f"{self._name}: {error}") from error

    @property
    def wants(self) -> str:
        """What the program wants to see: one of `INPUTS`."""
        if self._process is None:
            self._start()
        return self._wants

    def _start(self) -> None:
        """Start; if that has worked before, a failure now is not a mistake of the user."""
        try:
            self._launch()
            self._wants = self._greeting()
        except (DetectorError, DetectorTimeoutError, OSError) as error:
            self._stop()
            text = f"{WHERE}: {self._name} cannot be started: {error}"
            if self._was_ready:
                raise DetectorError(text) from error
            raise UserError(text) from error
        self._was_ready = True

    def _launch(self) -> None:
        end, self._lifeline = multiprocessing.Pipe(duplex=False)
        with end:
            self._process = subprocess.Popen(  # noqa: S603 (the user's own)
                self._command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,  # so that all that it starts can be stopped with it
                pass_fds=[end.fileno()],
            )
            kill_when_closed(end, -self._process.pid)
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                os.set_blocking(pipe.fileno(), False)

    def _greeting(self) -> str:
        hello = self._exchange(b"", self._starting_limit)
        if not isinstance(hello, dict) or hello.get("protocol") != PROTOCOL:
            raise DetectorError(
                f"it must begin with the message {{protocol: {PROTOCOL}, observes: ...}}"
            )
        wanted = hello.get("observes")
        if wanted not in INPUTS:
            raise DetectorError(f"it observes {wanted!r}; allowed: {', '.join(INPUTS)}")
        return str(wanted)

    def _exchange(self, message: bytes, limit: float) -> Any:  # noqa: ANN401 (what it sends)
        """Send a message unless it is empty, and receive one. Stop the program if that fails."""
        outgoing = LENGTH.pack(len(message)) + message if message else b""
        try:
            return unpacked(self._transfer(outgoing, time.monotonic() + limit))
        except TimeoutError as error:
            self._stop()
            raise DetectorTimeoutError(f"{self._name} did not answer in {limit:g} s") from error
        except (EOFError, OSError) as error:
            raise DetectorError(f"{self._name} {self._ending()}") from error
        except ValueError as error:
            self._stop()
            raise DetectorError(f"{self._name}: {error}") from error

    def _transfer(self, outgoing: bytes, deadline: float) -> bytes:
        """Write bytes, and read one message meanwhile, because a program may write first."""
        process = self._process
        if process is None or process.stdin is None or process.stdout is None:
            raise EOFError
        rest, incoming = memoryview(outgoing), bytearray()
        with selectors.DefaultSelector() as ready:
            ready.register(process.stdout, selectors.EVENT_READ)
            if rest:
                if ready.select(0):
                    if not os.read(process.stdout.fileno(), PIECE):
                        raise EOFError
                    raise ValueError(
                        "it wrote without being asked. Does it print to standard output?"
                    )
                ready.register(process.stdin, selectors.EVENT_WRITE)
            while rest or not _is_complete(incoming):
                for key, _ in _wait(ready, deadline):
                    if key.fileobj is process.stdin:
                        rest = rest[os.write(key.fd, rest[:PIECE]) :]
                        if not rest:
                            ready.unregister(process.stdin)
                    elif piece := os.read(key.fd, PIECE):
                        incoming += piece
                    else:
                        raise EOFError
        return bytes(incoming[LENGTH.size :])

    def _ending(self) -> str:
        """How a program that no longer answers ended, in words."""
        status = self._stop(ENDING_TIME)
        return "hung up" if status is None else f"ended with status {status}; see its messages"

    def _stop(self, patience: float = 0.0) -> int | None:
        """End the program and all that it started; returns its status if it ended by itself."""
        process, self._process = self._process, None
        if process is None:
            return None
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()  # it ends by itself when it can receive no more requests
        status = None
        with contextlib.suppress(subprocess.TimeoutExpired):
            status = process.wait(patience)
        self._signal(process, signal.SIGTERM)  # `docker run` and the like pass it on
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(ENDING_TIME)
        self._signal(process, signal.SIGKILL)
        process.wait()
        self._lifeline.close()
        return status

    def _signal(self, process: subprocess.Popen[bytes], number: signal.Signals) -> None:
        """Send a signal to the program and all that it started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)


def _wait(
    ready: selectors.BaseSelector, deadline: float
) -> list[tuple[selectors.SelectorKey, int]]:
    left = deadline - time.monotonic()
    events = ready.select(left) if left > 0 else []
    if not events:
        raise TimeoutError
    return events


def _is_complete(incoming: bytearray) -> bool:
    """Whether bytes are one message; ValueError if they are more, or it is too long."""
    if len(incoming) < LENGTH.size:
        return False
    length = int(LENGTH.unpack_from(incoming)[0])
    if length > MAX_BYTES:
        raise ValueError(
            f"a message of {length} bytes; at most {MAX_BYTES} are allowed. Does it print to "
            "standard output?"
        )
    if len(incoming) > LENGTH.size + length:
        raise ValueError("more than one message at once. Does it print to standard output?")
    return len(incoming) == LENGTH.size + length
