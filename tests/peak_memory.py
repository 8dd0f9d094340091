"""What reading a file takes: measured in a process that reads one file after the other."""

import multiprocessing
import re
import resource
import time
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from egad._util.limited import LimitedProcess, limited

MEGABYTE = 1 << 20
MEMORY = 1 << 30  # a quarter of what files may take otherwise: less takes less time to fill


class Cost(NamedTuple):
    """What came of reading a file: the words of the result or of the error, and what it took.

    Attributes:
        outcome: Type and text of the error, or what the reader returned.
        own: Peak of the memory of the process that reads, above what it had before, bytes.
        limited: Peak of the memory of any process that it has limited so far, bytes.
        seconds: Time.
    """

    outcome: str
    own: int
    limited: int
    seconds: float


@contextmanager
def measured(warm, seconds):
    """A function from a reader and a path to its `Cost`; the limited process has `MEMORY`.

    A reader takes a path and returns what to say of the file; its name must be importable.

    Args:
        warm: A small file that is read in the limited process, which is started by that.
        seconds: Limit on the time of a call of that process.
    """
    context = multiprocessing.get_context("spawn")
    pipe, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, warm, seconds))
    process.start()
    theirs.close()

    def ask(read, path):
        pipe.send((read, path))
        return pipe.recv()

    try:
        yield ask
    finally:
        pipe.close()
        process.join()


def _serve(pipe, warm, seconds):
    limited.__init__(memory=MEMORY)
    while True:
        try:
            read, path = pipe.recv()
        except EOFError:
            return
        read(warm)  # anew, if the last file ended it
        pipe.send(_cost(read, path, limited, seconds))


def _cost(read, path, process: LimitedProcess, seconds):
    worker = process._worker
    usual, worker._limit = worker._limit, seconds
    before = _forget_peak("self")
    child = worker._process.pid
    _forget_peak(child)
    start = time.monotonic()
    try:
        outcome = read(path)
    except Exception as error:
        outcome = f"{type(error).__name__}: {error}"
    took = time.monotonic() - start
    worker._limit = usual
    ended = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
    alive = worker.running and worker._process.pid == child
    return Cost(
        outcome, _memory("self", "VmHWM") - before, max(ended, _memory(child) if alive else 0), took
    )


def _forget_peak(process):
    """Begin a new peak of a process, and say how much memory it has."""
    Path(f"/proc/{process}/clear_refs").write_text("5")
    return _memory(process, "VmRSS")


def _memory(process, which="VmHWM"):
    text = Path(f"/proc/{process}/status").read_text()
    return 1024 * int(re.search(rf"{which}:\s+(\d+) kB", text)[1])
