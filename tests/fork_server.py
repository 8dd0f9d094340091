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

import fontTools.subset  # noqa: F401 (matplotlib imports it late)
import igl  # noqa: F401
import matplotlib.backends.backend_pdf
import matplotlib.backends.backend_svg  # noqa: F401
import mujoco  # noqa: F401
import nbformat.validator  # noqa: F401 (Snakemake imports it late)
import numba
import scipy.stats  # noqa: F401 (our library imports it late)
import smart_open  # noqa: F401 (as nbformat)
import snakemake.benchmark
import snakemake.executors.dryrun
import snakemake.executors.local  # noqa: F401
from forks import ROOT, Forked, forked
from PIL import Image
from snakemake.cli import get_argument_parser, main
from threadpoolctl import threadpool_limits

import egad.bench.attempts
import egad.data
import egad.detectors.ggcnn
import egad.io.sums
import egad.learning.images.splits
import egad.report.archive_map
import egad.sim.mujoco_world  # noqa: F401

# what the workflow, its jobs and workers import
import egad_workflow.check
import egad_workflow.display
import egad_workflow.input_files
import egad_workflow.job
import egad_workflow.settings
import egad_workflow.shards  # noqa: F401
from egad._util.kernel_cache import compiled_marker
from egad_workflow import code_version
from egad_workflow.check import schema
from egad_workflow.precompile import compile_fusion, compile_grasps, compile_measures

STARTED = "EGAD_TESTS_STARTED"  # a variable: jobs are started, not forked
version = code_version.code_version
HIGH = 200  # beyond the numbers of files that anybody asks for
SCRIPT = re.compile(rf"{re.escape(sys.executable)} (\S+/\.snakemake/scripts/\S+\.py)$")


def serve(number):
    """Fork for everybody who connects, until the input of this process ends."""
    _load()
    # `snakemake.shell` is also the name of a class in `snakemake`
    shell = importlib.import_module("snakemake.shell")
    shell.sp = SimpleNamespace(**{**vars(subprocess), "Popen": job_process})
    ended, waker = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(waker, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    gc.freeze()
    asking = {}  # who waits for the end of each process
    with forked(), socket.socket(fileno=number) as listener:
        while 0 not in (ready := select([listener, 0, ended], [], [])[0]):
            if ended in ready:
                os.read(ended, 1 << 16)
                _tell_of_ends(asking)
            if listener in ready:
                asked, _ = listener.accept()
                _, files, _, _ = socket.recv_fds(asked, 1, 64)
                with asked.makefile() as lines:
                    request = lines.readline()
                if not request:  # whoever asked has ended
                    asked.close()
                elif process := os.fork():
                    asking[process] = asked
                    _tell(asked, process)
                else:
                    signal.set_wakeup_fd(-1)
                    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                    for each in (listener, asked, *asking.values()):
                        each.close()
                    _become(files=files, **json.loads(request))
                for file in files:
                    os.close(file)


def _load():
    """Load what the scripts of the workflow need, but not them, and what is first used late."""
    get_argument_parser()  # finds all plugins
    Image.preinit()
    schema()
    folder = ROOT / "workflow/scripts"
    sys.path.insert(0, str(folder))
    for path in folder.glob("*.py"):
        importlib.import_module(path.stem)
        del sys.modules[path.stem]
    sys.path.remove(str(folder))
    code_version.code_version = _version_of_copies(folder)
    if compiled_marker().exists():
        compile_grasps()
        compile_measures()
        compile_fusion()


def _version_of_copies(folder):
    """The function `code_version`, which knows the versions of copies of scripts in a folder."""
    known = {(path.name, path.read_bytes()): version(path) for path in folder.glob("*.py")}

    def version_of(module, *package):
        path = Path(module)
        copied = path.suffix == ".py" and not package and known.get((path.name, path.read_bytes()))
        return copied or version(module, *package)

    return version_of


def _tell_of_ends(asking):
    """Tell whoever waits for a process that has ended."""
    with suppress(ChildProcessError):  # there are none
        while (end := os.waitpid(-1, os.WNOHANG))[0]:
            with asking.pop(end[0]) as asked:
                _tell(asked, os.waitstatus_to_exitcode(end[1]))


def _tell(asked, number):
    with suppress(OSError):  # whoever asked has ended
        asked.sendall(f"{number}\n".encode())


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
    where = Path(os.environ.get("PYTHONPATH", ROOT))
    if where != ROOT and (where / "egad").is_dir():
        _take_library(where)
    if words[:2] == ["-m", "snakemake"]:
        sys.argv, sys.path[0] = ["snakemake", *words[2:]], str(Path.cwd())
        main()
    elif first == "-c":
        sys.argv = ["-c", *others[1:]]
        sys.path[0] = ""
        exec(others[0], vars(program))  # noqa: S102
    else:
        sys.argv, sys.path[0] = words, str(Path(first).parent)
        vars(program)["__file__"] = first
        threadpool_limits(int(os.environ.get("OPENBLAS_NUM_THREADS", "1")))
        exec(compile(Path(first).read_bytes(), first, "exec"), vars(program))  # noqa: S102


def _take_library(folder):
    """Let the library be imported anew, from another folder; sources that were read are kept."""
    read = code_version._parsed
    for name in list(sys.modules):
        if name.partition(".")[0] in ("egad", "egad_workflow"):
            del sys.modules[name]
    sys.path.insert(1, str(folder))
    importlib.import_module("egad_workflow.code_version")._parsed = read


def job_process(command, *, env, **options):
    """In place of `subprocess.Popen` in `snakemake.shell`."""
    script = SCRIPT.search(command)
    if script is None or env["PYTHONPATH"] != str(ROOT) or STARTED in env:
        return subprocess.Popen(command, env=env, **options)
    return Forked([script[1]], environment=env)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
