"""What worker processes of tests do, in a module that they import in little time."""

import atexit
import os
import signal
import threading
import time
import warnings
from contextlib import contextmanager

from threadpoolctl import threadpool_info

from egad.errors import UserError


def killed(number):
    """What the kernel does when memory runs out."""
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)


@contextmanager
def halving(marks):
    """Halves numbers; 0 ends the process the first time, 13 always, and text is an error."""

    def half(number):
        killed(number)
        if number == 13 or (number == 0 and not marks.exists()):
            marks.touch()
            os.abort()
        return number / 2

    marks.with_suffix(".open").touch()
    yield half
    marks.with_suffix(".closed").touch()


@contextmanager
def refusing():
    raise UserError("this cannot be made")
    yield


@contextmanager
def dying():
    os.abort()
    yield


class PathError(UserError):
    """One that is pickled, but cannot be unpickled: it is made from something else."""

    def __init__(self, path, reason):
        super().__init__(f"{path}: {reason}")


class LocalError(Exception):
    """One that cannot be pickled."""

    def __reduce__(self):
        raise TypeError("not this one")


@contextmanager
def raising():
    def work(item):
        if item == "user":
            raise PathError("a.h5", "damaged")
        if item == "local":
            raise LocalError("what went wrong")
        return threading.Lock() if item == "result" else os.getpid()

    yield work


@contextmanager
def not_starting():
    raise LocalError("no such engine")
    yield


class Unreadable:
    """A result that another process makes and this one cannot."""

    def __reduce__(self):
        return open, ("/no/such/file",)


@contextmanager
def unreadable():
    yield lambda item: Unreadable() if item == "result" else os.getpid()


@contextmanager
def ending_a_file():
    raise EOFError("the weights are cut off")
    yield


@contextmanager
def sleeping(marks):
    """Naps; 0 oversleeps the first time, 13 always."""

    def nap(number):
        if number == 13 or (number == 0 and not marks.exists()):
            marks.touch()
            time.sleep(600)
        return number / 2

    yield nap
    if marks.with_suffix(".last").exists():
        time.sleep(600)


def threads_for_algebra(matrix):
    assert (matrix @ matrix == matrix).all()
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def warned(number):
    warnings.warn(f"{number} is odd", UserWarning, stacklevel=1)
    return number


def crashed(mesh):
    if mesh["name"] == "B1":
        os.abort()


def failed(number):
    if number == 0:
        raise ZeroDivisionError("no such number")
    time.sleep(600)


def wait_for(folder, pattern, count):
    end = time.monotonic() + 60
    while len(list(folder.glob(pattern))) < count and time.monotonic() < end:
        time.sleep(0.01)


def finalized(folder):
    """Runs in two processes, and leaves a file when both of them end at the same time."""

    def finalize():
        (folder / f"{os.getpid()}.ending").touch()
        wait_for(folder, "*.ending", 2)
        (folder / f"{os.getpid()}.ended").touch()

    atexit.register(finalize)
    (folder / f"{os.getpid()}.started").touch()
    wait_for(folder, "*.started", 2)
    return os.getpid()


class Counted:
    """Work that counts how often it is pickled, and unpickled in each process."""

    pickled = unpickled = 0

    def __getstate__(self):
        Counted.pickled += 1
        return "sent"

    def __setstate__(self, state):
        Counted.unpickled += 1

    def __call__(self, _):
        return Counted.unpickled
