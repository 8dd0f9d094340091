"""Running the script of a stage: the names in its rule are the arguments of its function.

For example, a script defines `run(settings, objects, meshes, grasps, jobs)` and ends with

    if __name__ == "__main__":
        run_job(run)

Its rule then has `params: settings=...`, `input: objects=..., meshes=...` and `output: grasps=...`.
Wildcards are arguments as well, unless a param has the same name, and `jobs` is the number of
threads. If the outputs are files in a folder, the folder is the param `out`.
pydantic converts strings to paths and numbers, and tables of settings to the classes in the
signature of the function.
"""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from inspect import signature
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import validate_call

from egad.io import write_sums
from egad_workflow.program import readable_errors, start_logging
from egad_workflow.provenance import recorded

FOLDERS = ("meshes", "bundle")  # params that are read: an input is a table in each


def run_job(function: Callable[..., object]) -> None:
    """Run the function of a script, where Snakemake puts the object `snakemake`, as a job."""
    job = vars(sys.modules["__main__"])["snakemake"]
    for log in job.log[:1]:
        _write_messages_to(Path(log))
    start_logging()
    logging.getLogger(function.__module__).setLevel(logging.INFO)
    params = dict(job.params.items())
    arguments = arguments_of(function, job)
    folders = [params[name] for name in FOLDERS if name in params]
    # The provenance of a table is written into it; that of other files, next to them.
    with (
        readable_errors(),
        recorded(
            job.rule,
            code=params.get("code", ""),
            settings=params.get("settings"),
            arguments=dict(job.wildcards.items()),
            inputs=[Path(path) for path in [*job.input, *folders]],
        ),
    ):
        told = validate_call(function)(**arguments)
        if isinstance(told, str):
            print(told)
        for path in _other_files(job):
            write_sums(path)


def arguments_of(function: Callable[..., object], job: Any) -> dict[str, Any]:  # noqa: ANN401
    """The arguments of a function in the object `snakemake`, not yet converted to its types."""
    hints = get_type_hints(function)
    found: dict[str, Any] = {"jobs": job.threads, **dict(job.wildcards.items())}
    found |= dict(job.params.items())
    taken = set(job.params.keys())
    for values in (job.input, job.output):
        named = {
            name: _files(value, hints[name]) for name, value in values.items() if name in hints
        }
        if twice := sorted(named.keys() & taken):
            raise TypeError(f"rule {job.rule} has {twice[0]!r} twice")
        taken |= named.keys()
        found |= named
    return {name: found[name] for name in signature(function).parameters if name in found}


def _files(value: Any, wanted: Any) -> Any:  # noqa: ANN401 (what Snakemake has, and a type)
    """The files of a name as a list or a single file, as the type wants; none if there are none."""
    files = [value] if isinstance(value, str) else list(value)
    if any(get_origin(each) is list for each in (wanted, *get_args(wanted))):
        return files
    return files[0] if files else None


def _other_files(job: Any) -> Iterator[Path]:  # noqa: ANN401 (of Snakemake)
    """Files and folders that are written, other than tables."""
    folder = job.params.get("out")
    written = job.output if folder is None else [folder]
    for path in map(Path, written):
        if path.suffix != ".parquet":
            yield path


def _write_messages_to(log: Path) -> None:
    """Redirect everything that this process and its children print to a file."""
    with log.open("w", encoding="utf-8") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
