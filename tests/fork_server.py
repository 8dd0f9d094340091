"""The process that `forks.py` starts and asks: it has loaded Snakemake and the library."""

import atexit
import fcntl
import gc
import importlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from pathlib import Path
from select import select
from types import ModuleType, SimpleNamespace

import mujoco  # noqa: F401
import nbformat.validator  # noqa: F401 (Snakemake imports it late)
import numba
import smart_open  # noqa: F401 (the same)
import snakemake.executors.dryrun
import snakemake.executors.local  # noqa: F401
import trimesh
from forks import PARENT, ROOT, Forked, forked
from snakemake.cli import get_argument_parser, main
from threadpoolctl import threadpool_limits

# what the workflow, its jobs and workers import
import egad.config.check
import egad.config.input_files
import egad.config.schema
import egad.config.stages
import egad.data
import egad.detectors.ggcnn
import egad.io.sums
import egad.perception.splits
import egad.workflow.display
import egad.workflow.job
import egad.workflow.shards
import egad.workflow.simulations  # noqa: F401
from egad.measures.complexity import complexity
from egad.workflow import definitions
from egad.workflow.code_version import code_version

STARTED = "EGAD_TESTS_STARTED"  # a variable: jobs are started, not forked
HIGH = 200  # beyond the numbers of files that anybody asks for
SCRIPT = re.compile(rf"{re.escape(sys.executable)} (\S+/\.snakemake/scripts/\S+\.py)$")


def serve(number):
    """Fork for everybody who connects, until the input of this process ends."""
    get_argument_parser()  # finds all plugins
    for path in (ROOT / "workflow/scripts").glob("*.py"):
        code_version(path)
    complexity(trimesh.creation.box(), 8)  # numba prepares itself when it is first used
    # `snakemake.shell` is also the name of a class in `snakemake`
    shell = importlib.import_module("snakemake.shell")
    shell.sp = SimpleNamespace(**{**vars(subprocess), "Popen": job_process})
    signal.signal(signal.SIGCHLD, _reap)
    gc.freeze()
    with forked(), socket.socket(fileno=number) as listener:
        while 0 not in select([listener, 0], [], [])[0]:
            asked, _ = listener.accept()
            with asked:
                if not os.fork():
                    try:
                        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                        listener.close()
                        _answer(asked)
                    finally:
                        os._exit(0)


def _reap(*_):
    """Let children that have ended go."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _answer(asked):
    """Fork for a request: say the process, then its exit status."""
    _, files, _, _ = socket.recv_fds(asked, 1, 64)
    with asked.makefile() as lines:
        request = json.loads(lines.readline())
    process = os.fork()
    if not process:
        asked.close()
        _become(files=files, **request)
    for file in files:
        os.close(file)
    asked.sendall(f"{process}\n".encode())
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    with suppress(OSError):  # whoever asked has ended
        asked.sendall(f"{status}\n".encode())


def _become(words, folder, environment, numbers, own_session, files):
    """Turn this process into one that runs Python with some arguments."""
    status = 1
    try:
        if own_session:
            os.setsid()
        kept = [fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, HIGH) for file in files]
        for file, number in zip(kept, numbers, strict=True):
            os.dup2(file, number)
            os.close(file)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        tempfile.tempdir = None
        numba.config.reload_config()
        _run(words)
        status = 0
    except SystemExit as end:
        status = end.code or 0
        if isinstance(status, str):
            print(status, file=sys.stderr)
            status = 1
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        threading._shutdown()
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(status)


def _run(words):
    """Run Python with some arguments, in this process."""
    first, *others = words
    program = sys.modules["__main__"] = ModuleType("__main__")
    if words[:2] == ["-m", "snakemake"]:
        sys.argv, sys.path[0] = ["snakemake", *words[2:]], str(Path.cwd())
        if os.environ["PYTHONPATH"] != str(ROOT):
            _forget_library()
        main()
    elif first == "-c":
        parent = str(os.getppid())
        sys.argv = ["-c", *(parent if word == PARENT else word for word in others[1:])]
        sys.path[0] = ""
        exec(others[0], vars(program))  # noqa: S102
    else:
        sys.argv, sys.path[0] = words, str(Path(first).parent)
        vars(program)["__file__"] = first
        threadpool_limits(int(os.environ.get("OPENBLAS_NUM_THREADS", "1")))
        exec(compile(Path(first).read_bytes(), first, "exec"), vars(program))  # noqa: S102


def _forget_library():
    """Let the library be imported anew, from another folder; sources that were read are kept."""
    read = definitions._parsed
    for name in list(sys.modules):
        if name.partition(".")[0] == "egad":
            del sys.modules[name]
    sys.path.insert(1, os.environ["PYTHONPATH"])
    importlib.import_module("egad.workflow.definitions")._parsed = read


def job_process(command, *, env, **options):
    """In place of `subprocess.Popen` in `snakemake.shell`."""
    script = SCRIPT.search(command)
    if script is None or env["PYTHONPATH"] != str(ROOT) or STARTED in env:
        return subprocess.Popen(command, env=env, **options)
    return Forked([script[1]], environment=env)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
