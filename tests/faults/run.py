"""Whether the tests notice faults: those of `faults.yaml`, one at a time, in a copy of a checkout.

`python tests/faults/run.py CHECKOUT --scratch FOLDER --out RESULTS.json` runs the tests of the
package of every fault until one fails. Results are kept as they come, and a second call does what
is left.
"""

import argparse
import csv
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import yaml

FAULTS = Path(__file__).with_name("faults.yaml")
LIMIT = 7200  # seconds of the tests of a package; each has a limit of its own, so none hangs
LONGEST = 3600  # seconds of a test: a busy machine is no fault
# The tests of the workflow that take long come last.
EARLY = ("profiles", "plans", "failures", "results")
MARK = ".copy-for-faults"
FAILURE = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
CAUGHT, UNNOTICED = "caught", "not caught"


@dataclass(frozen=True)
class Fault:
    """A single mistake.

    Attributes:
        id: Its name.
        file: Where it is, relative to the checkout.
        old: Text that is there exactly once.
        new: What it becomes.
        tests: Folder, file or pattern of the tests that should notice it.
        kind: What kind of mistake it is.
    """

    id: str
    file: str
    old: str
    new: str
    tests: str
    kind: str

    def edit(self, text: str) -> str | None:
        """The text of the file with the fault; None if its place is not there exactly once."""
        return text.replace(self.old, self.new) if text.count(self.old) == 1 else None


@dataclass(frozen=True)
class Outcome:
    """What the tests of a package said.

    Attributes:
        status: `caught`, `not caught`, or what went wrong.
        first: The first test that failed; empty if none did.
        wall: Seconds.
        cpu: Seconds of user and system time of all processes.
    """

    status: str
    first: str = ""
    wall: float = 0.0
    cpu: float = 0.0


def main() -> int:
    """Run what the command line asks for; 1 if a fault could not be tried."""
    options = _options()
    faults = [Fault(**fault) for fault in yaml.safe_load(options.faults.read_text("utf-8"))]
    faults = [fault for fault in faults if re.search(options.only, fault.id)]
    if options.listed:
        with options.listed.open(encoding="utf-8", newline="") as file:
            listed = {row["id"] for row in csv.DictReader(file)}
        faults = [fault for fault in faults if fault.id in listed]
    checkout, scratch = options.checkout.resolve(), options.scratch.resolve()
    copy_tracked(checkout, scratch)
    known = json.loads(options.out.read_text("utf-8")) if options.out.exists() else {}
    for fault in faults:
        if fault.id in known and known[fault.id]["status"] in (CAUGHT, UNNOTICED):
            continue
        outcome = tried(checkout, scratch, fault, options.limit)
        known[fault.id] = asdict(outcome)
        options.out.write_text(json.dumps(known, indent=1) + "\n", "utf-8")
        print(f"{time.strftime('%H:%M:%S')}  {fault.id}: {_line(outcome)}", flush=True)
    _tell(faults, known)
    if options.csv:
        _write_csv(options.csv, faults, known)
    wrong = [fault for fault in faults if known[fault.id]["status"] not in (CAUGHT, UNNOTICED)]
    return int(bool(wrong))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path, help="folder of the code to try")
    parser.add_argument("--scratch", type=Path, required=True, help="folder of the copy to change")
    parser.add_argument("--out", type=Path, required=True, help="JSON file of results, kept")
    parser.add_argument("--faults", type=Path, default=FAULTS, help="YAML file of faults")
    parser.add_argument("--only", default="", help="regular expression of the ids to try")
    parser.add_argument("--listed", type=Path, help="table of results: try the faults in it alone")
    parser.add_argument("--csv", type=Path, help="table of results to write")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds for a fault")
    return parser.parse_args()


def copy_tracked(checkout: Path, scratch: Path) -> None:
    """Copy the files that git knows, as they are now; times are kept, so compiled code stays good.

    Other files of an earlier copy are removed, apart from compiled code.
    """
    if scratch.exists() and any(scratch.iterdir()) and not (scratch / MARK).is_file():
        raise SystemExit(f"{scratch} is not a copy that this program made; name another folder")
    listed = subprocess.run(
        ["git", "-C", checkout, "ls-files", "-z"], check=True, capture_output=True, text=True
    )
    names = [name for name in listed.stdout.split("\0") if (checkout / name).is_file()]
    for name in names:
        target = scratch / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(checkout / name, target)
    (scratch / MARK).touch()
    known = {scratch / name for name in [*names, MARK]}
    for path in scratch.rglob("*"):
        if path.is_file() and path not in known and "__pycache__" not in path.parts:
            path.unlink()


def files_for(folder: Path, fault: Fault) -> list[str]:
    """The test files of a fault, those first that are named after the faulty module."""
    path = folder / fault.tests
    found = path.rglob("test_*.py") if path.is_dir() else folder.glob(fault.tests)
    stem = Path(fault.file).stem

    def key(file: Path) -> tuple[int, bool, str]:
        name = file.stem.removeprefix("test_")
        place = EARLY.index(name) if name in EARLY else len(EARLY)
        number = place if fault.tests == "tests/workflow" else 0
        return number, stem not in name, name

    return [str(file.relative_to(folder)) for file in sorted(found, key=key)]


def tried(checkout: Path, scratch: Path, fault: Fault, limit: float) -> Outcome:
    """What the tests say with a fault."""
    files = files_for(scratch, fault)
    if not files:
        return Outcome("error: there are no tests")
    source = checkout / fault.file
    if not source.is_file() or fault.edit(source.read_text("utf-8")) is None:
        return Outcome(f"error: the text is not once in {fault.file}")
    with faulty(source, scratch, fault):
        return run_tests(scratch, [*files, "-x"], limit)


@contextmanager
def faulty(source: Path, scratch: Path, fault: Fault) -> Iterator[None]:
    """The copy with a fault; then as it was, without what was compiled from the fault."""
    target, cache, text = (
        scratch / fault.file,
        scratch / "egad/__pycache__",
        source.read_text("utf-8"),
    )
    kernels = set(cache.glob("kernels-*"))
    target.write_text(str(fault.edit(text)), "utf-8")
    try:
        yield
    finally:
        shutil.copy2(source, target)
        if "@kernel(" in text:
            for folder in set(cache.glob("kernels-*")) - kernels:
                shutil.rmtree(folder)


def run_tests(folder: Path, arguments: Sequence[str], limit: float) -> Outcome:
    """Run tests in one process, in a folder, with the library that lies there."""
    paths = [str(Path(sys.executable).parent), *os.get_exec_path()]
    environment = os.environ | {
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PATH": os.pathsep.join(paths),
    }
    with tempfile.TemporaryDirectory(prefix="faults-") as temporary:
        command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider"]
        command += [f"--basetemp={temporary}/tests", f"--timeout={LONGEST}", *arguments]
        start, before = time.monotonic(), _cpu()
        status, said = _run(command, folder, environment, limit)
    wall, cpu = round(time.monotonic() - start, 1), round(_cpu() - before, 1)
    failures = FAILURE.findall(said)
    if status == 0:
        return Outcome(UNNOTICED, "", wall, cpu)
    if status is None:
        return Outcome("error: time limit", "", wall, cpu)
    if failures or status < 0:
        return Outcome(CAUGHT, (failures or ["a process that ended"])[0], wall, cpu)
    return Outcome(f"error: pytest ended with status {status}: {said[-300:]}", "", wall, cpu)


def _run(
    command: list[str], folder: Path, environment: dict[str, str], limit: float
) -> tuple[int | None, str]:
    """The exit status and the output of a command; no status if it took too long."""
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            said, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            said, _ = process.communicate()
            return None, said
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    return process.returncode, said


def _cpu() -> float:
    """Seconds of user and system time of all processes that ended so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _line(outcome: Outcome) -> str:
    return f"{outcome.status}  {outcome.first}  {outcome.wall:.0f} s, {outcome.cpu:.0f} s of CPU"


def _tell(faults: list[Fault], known: dict[str, dict[str, object]]) -> None:
    """Print how many faults of each package were noticed, and which were not."""
    print(f"{'tests':24}{'faults':>8}{'caught':>8}")
    for tests in [*dict.fromkeys(fault.tests for fault in faults), ""]:
        own = [fault.id for fault in faults if tests in ("", fault.tests)]
        caught = sum(known[name]["status"] == CAUGHT for name in own)
        print(f"{tests or 'all':24}{len(own):8}{caught:8}")
    for fault in faults:
        if (status := known[fault.id]["status"]) != CAUGHT:
            print(f"{fault.id}: {status}")


def _write_csv(path: Path, faults: list[Fault], known: dict[str, dict[str, object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["id", "status", "first failing test"])
        for fault in faults:
            writer.writerow([fault.id, known[fault.id]["status"], known[fault.id]["first"]])


if __name__ == "__main__":
    raise SystemExit(main())
