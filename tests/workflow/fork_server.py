"""A process that has loaded Snakemake and the library, and forks for each run of Snakemake.

The copy goes to the folder of the run, takes its environment and arguments, and ends with it. So no
run sees what another one left in memory.
"""

import gc
import json
import os
import sys
import traceback
from pathlib import Path

import nbformat.validator  # noqa: F401 (Snakemake imports it late)
import smart_open  # noqa: F401 (the same)
import snakemake.executors.dryrun
import snakemake.executors.local  # noqa: F401
from snakemake.cli import get_argument_parser, main

# what the workflow imports
import egad.config.check
import egad.config.input_files
import egad.config.schema
import egad.config.stages
import egad.data
import egad.detectors.ggcnn
import egad.io.sums
import egad.perception.splits
import egad.workflow.display
import egad.workflow.shards  # noqa: F401
from egad.workflow.code_version import code_version

ROOT = Path(__file__).parents[2]


def serve():
    """Fork for every request on the standard input: say its process, then its exit status."""
    get_argument_parser()  # finds all plugins
    for path in (ROOT / "workflow/scripts").glob("*.py"):
        code_version(path)
    gc.freeze()
    for line in sys.stdin:
        run = os.fork()
        if not run:
            become(**json.loads(line))
        print(run, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(run, 0)[1]), flush=True)


def become(arguments, folder, environment, output):
    """Turn this process into a run of Snakemake."""
    os.setsid()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for stream in (1, 2):
        os.dup2(os.open(output, os.O_WRONLY | os.O_APPEND), stream)
    sys.path[0] = folder
    sys.argv = ["snakemake", *arguments]
    if environment["PYTHONPATH"] != str(ROOT):
        forget("egad")
        sys.path.insert(1, environment["PYTHONPATH"])
    status = 1
    try:
        main()
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def forget(package):
    """Let a package be imported anew, from another folder."""
    for name in list(sys.modules):
        if name == package or name.startswith(f"{package}."):
            del sys.modules[name]


if __name__ == "__main__":
    serve()
