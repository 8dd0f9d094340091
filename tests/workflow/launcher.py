"""Snakemake without its seconds of imports: `fork_server.py` spends them once for many runs."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
SERVER = Path(__file__).with_name("fork_server.py")


class Launcher:
    """Runs Snakemake as `python -m snakemake` would, in forks of one process."""

    def __init__(self):
        self._server = None

    def run(self, arguments, folder, environment):
        """Run Snakemake in a folder to its end: its exit status and what it said."""
        with tempfile.NamedTemporaryFile("r", encoding="utf-8") as said:
            request = {
                "arguments": arguments,
                "folder": str(folder),
                "environment": environment,
                "output": said.name,
            }
            return self._status(request), said.read()

    def stop(self):
        """End the server."""
        if self._server:
            self._server.communicate()

    def _status(self, request):
        """The exit status of a run. One that is given up is killed with all its jobs."""
        self._server = self._server or _server()
        self._server.stdin.write(f"{json.dumps(request)}\n")
        self._server.stdin.flush()
        run = int(self._server.stdout.readline())
        try:
            return int(self._server.stdout.readline())
        except BaseException:
            os.killpg(run, signal.SIGKILL)
            self._server.stdout.readline()
            raise


def _server():
    return subprocess.Popen(
        [sys.executable, SERVER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        text=True,
    )
