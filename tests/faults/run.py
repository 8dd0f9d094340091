"""Whether the tests notice the faults of `faults.yaml`, one at a time, in a copy of the checkout.

`python tests/faults/run.py` runs the tests of each fault until one fails. Results are kept in
`build/faults.json` as they come, and a second call does what is left.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
COPY, RESULTS = ROOT / "build/faults", ROOT / "build/faults.json"
LONGEST = 3600  # seconds of a test: a busy machine is no fault
CAUGHT, UNNOTICED = "caught", "not caught"


def main() -> int:
    """Try what the command line asks for; 1 if a fault was not caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="regular expression of the faults to try")
    only = parser.parse_args().only
    faults = yaml.safe_load(Path(__file__).with_name("faults.yaml").read_text("utf-8"))
    if misplaced := [fault["id"] for fault in faults if not has_its_place(fault)]:
        raise SystemExit(f"not exactly once in the file, or without tests: {', '.join(misplaced)}")
    copy()
    known = json.loads(RESULTS.read_text("utf-8")) if RESULTS.exists() else {}
    chosen = [fault for fault in faults if re.search(only, fault["id"])]
    for fault in chosen:
        if fault["id"] not in known:
            known[fault["id"]] = tried(fault)
            RESULTS.write_text(json.dumps(known, indent=1) + "\n", "utf-8")
        print(f"{fault['id']}: {known[fault['id']]}", flush=True)
    missed = [fault["id"] for fault in chosen if known[fault["id"]] == UNNOTICED]
    print(f"caught {len(chosen) - len(missed)} of {len(chosen)}; not {', '.join(missed) or 'one'}")
    return bool(missed)


def has_its_place(fault: dict[str, str]) -> bool:
    """Whether the text of a fault is in its file once, and there are tests for it."""
    text = (ROOT / fault["file"]).read_text("utf-8")
    return text.count(fault["old"]) == 1 and any(ROOT.glob(fault["tests"]))


def copy() -> None:
    """Copy the files that git knows, as they are; with their times, compiled code stays good."""
    listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True)
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (COPY / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, COPY / name)


def tried(fault: dict[str, str]) -> str:
    """What the tests say with a fault: the first that failed, or that none did."""
    path = COPY / fault["file"]
    text = path.read_text("utf-8")
    path.write_text(text.replace(fault["old"], fault["new"]), "utf-8")
    try:
        said = run_tests(tests_of(fault))
    finally:
        shutil.copy2(ROOT / fault["file"], path)
    if said.returncode == 0:
        return UNNOTICED
    failures = re.findall(r"^(?:FAILED|ERROR) (\S+)", said.stdout, re.MULTILINE)
    if not failures and said.returncode > 0:
        raise SystemExit(f"{fault['id']}: pytest did not run:\n{said.stdout[-2000:]}")
    return f"{CAUGHT} by {(failures or ['a process that ended'])[0]}"


def tests_of(fault: dict[str, str]) -> list[str]:
    """The test files of a fault, those first that are named after the faulty module."""
    stem = Path(fault["file"]).stem
    found = [
        file
        for path in COPY.glob(fault["tests"])
        for file in (path.rglob("test_*.py") if path.is_dir() else [path])
    ]
    return [str(file) for file in sorted(found, key=lambda file: (stem not in file.stem, file))]


def run_tests(files: list[str]) -> subprocess.CompletedProcess[str]:
    """Run tests in the copy, with the library that lies there, up to the first that fails."""
    paths = [str(Path(sys.executable).parent), *os.get_exec_path()]
    environment = {"PYTHONPATH": str(COPY), "PYTHONDONTWRITEBYTECODE": "1"}
    environment["PATH"] = os.pathsep.join(paths)
    return subprocess.run(
        [sys.executable, *f"-m pytest -q -x -n 0 --timeout={LONGEST}".split(), *files],
        cwd=COPY,
        env=os.environ | environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )


if __name__ == "__main__":
    raise SystemExit(main())
