"""Python processes without their seconds of imports: forks of one process that has made them.

A fork takes the arguments, the folder, the environment and the files of whoever asks, and ends with
what it runs. So none sees what another one left in memory. Tests of how processes start, and of how
much memory they take, start real ones.
"""

import atexit
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from select import select
from types import SimpleNamespace
from unittest.mock import patch

from egad._util import child_process

ROOT = Path(__file__).parents[1]
SERVER = Path(__file__).with_name("fork_server.py")
ADDRESS = "EGAD_TESTS_FORKS"  # the variable with the socket of the process that forks


class Forked:
    """What tests and programs need of `subprocess.Popen`, of a fork that runs Python."""

    def __init__(self, words, *, folder=None, environment=None, files=None, own_session=False):
        """Start.

        Args:
            words: Arguments of Python: those of `-c` or `-m snakemake`, or a script and its own.
            folder: To run in.
            environment: All variables.
            files: What each number of an open file there is here; the first three as here unless
                they are among them.
            own_session: Whether it leads a session, and a group of processes, of its own.
        """
        files = {0: 0, 1: 1, 2: 2} | (files or {})
        variables = dict(os.environ if environment is None else environment)
        request = {
            "words": [str(word) for word in words],
            "folder": str(folder or Path.cwd()),
            "environment": variables | {ADDRESS: server()},
            "numbers": list(files),
            "own_session": own_session,
        }
        self.args, self.returncode = words, None
        self._answers = socket.socket(socket.AF_UNIX)
        self._answers.connect(server())
        socket.send_fds(self._answers, [b"?"], list(files.values()))
        self._answers.sendall(f"{json.dumps(request)}\n".encode())
        self._lines = self._answers.makefile()
        self.pid = int(self._lines.readline())

    def poll(self):
        """The exit status, if it has ended."""
        return self._status(0)

    def wait(self, timeout=None):
        """The exit status, at the end."""
        if self._status(timeout) is None:
            raise subprocess.TimeoutExpired(self.args, timeout)
        return self.returncode

    def _status(self, timeout):
        if self.returncode is None and select([self._answers], [], [], timeout)[0]:
            told = self._lines.readline()  # nothing if the process that forks has ended
            self.returncode = int(told or -signal.SIGKILL)
            self._lines.close()
            self._answers.close()
        return self.returncode

    def kill(self):
        """End it."""
        self._signal(signal.SIGKILL)

    def terminate(self):
        """Ask it to end."""
        self._signal(signal.SIGTERM)

    def _signal(self, number):
        if self.poll() is None:
            os.kill(self.pid, number)


def python(words, **options):
    """Run Python to its end: what `subprocess.run` says of it.

    Args:
        words: As of `Forked`.
        options: As of `Forked`.
    """
    with tempfile.TemporaryFile("w+") as stdout, tempfile.TemporaryFile("w+") as stderr:
        files = {1: stdout.fileno(), 2: stderr.fileno()}
        status = Forked(words, files=files, **options).wait()
        for file in (stdout, stderr):
            file.seek(0)
        return subprocess.CompletedProcess(words, status, stdout.read(), stderr.read())


def worker_process(words, *, env, stdin, stdout, stderr, pass_fds):
    """In place of `subprocess.Popen` in `egad._util.child_process`."""
    with Path(os.devnull).open("r+b") as null:
        dropped = {
            number: null.fileno()
            for number, file in enumerate((stdin, stdout, stderr))
            if file == subprocess.DEVNULL
        }
        files = dropped | {number: number for number in pass_fds}
        return Forked(words[1:], environment=env, files=files)


@contextmanager
def forked():
    """Let workers of the library be forks."""
    stands_for_it = SimpleNamespace(**{**vars(subprocess), "Popen": worker_process})
    with patch.object(child_process, "subprocess", stands_for_it):
        yield


def server():
    """The address of the process that forks, which is started unless there is one."""
    return os.environ.get(ADDRESS) or _started()


@cache
def _started():
    folder = tempfile.TemporaryDirectory(prefix="egad-forks-")
    path = f"{folder.name}/socket"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        process = subprocess.Popen(
            [sys.executable, SERVER, str(listener.fileno())],
            stdin=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": str(ROOT), ADDRESS: path},
            pass_fds=[listener.fileno()],
            start_new_session=True,
        )
    atexit.register(folder.cleanup)
    atexit.register(process.communicate)  # it ends with its input
    return path
