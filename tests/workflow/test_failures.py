"""What goes wrong around the program: each ends with a sentence, and then with the same bytes."""

import os
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress

import numpy as np
import psutil
import pytest
from running_scripts import script_of

GRIPPER, DETECTOR = "egad_75mm", "antipodal-depth"
TRIALS = f"egad/trials/{GRIPPER}/{DETECTOR}.parquet"
PART = f"egad/parts/trials-{GRIPPER}-{DETECTOR}-0.parquet"
# What a new Python runs first: it waits for a file, but no longer than a minute.
WAITING = """
import os, time

end = time.monotonic() + 60
while not os.path.exists({file!r}) and time.monotonic() < end:
    time.sleep(0.05)
"""


@contextmanager
def mounted(folder, *options):
    """A mount for as long as the block lasts; without the right to mount, the test is skipped."""
    folder.mkdir(exist_ok=True)
    done = subprocess.run(["mount", *map(str, options), str(folder)], check=False)
    if done.returncode:
        pytest.skip("mounting is not permitted")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def make_trials(checkout):
    return checkout.make("--cores", 1, f"results/{TRIALS}")


def refused(checkout):
    """What a run says that cannot make the table of trials."""
    status, said = checkout.snakemake("--cores", 1, f"results/{TRIALS}")
    assert status != 0, said
    assert "Traceback" not in said
    return said


def test_a_full_disk_is_named_and_with_room_again_the_run_goes_on(copy):
    expected = copy.bytes()
    table = copy.results / TRIALS
    table.unlink()
    with mounted(table.parent, "-t", "tmpfs", "-o", "size=64k", "tmpfs"):
        with suppress(OSError):
            (table.parent / "filler").write_bytes(bytes(1 << 17))
        said = refused(copy)
        assert f"{table} cannot be written" in said
        assert "No space left on device" in said
    make_trials(copy)
    assert copy.bytes() == expected


def test_a_job_that_is_killed_for_memory_is_named_and_the_next_run_goes_on(copy):
    expected = copy.bytes()
    (copy.results / TRIALS).unlink()
    process = copy.start("--cores", 1, f"results/{TRIALS}")
    while process.poll() is None and not (jobs := jobs_of(process, "join")):
        time.sleep(0.02)
    jobs[0].kill()
    said, _ = process.communicate()
    assert process.returncode == 1
    assert "Error in rule join_trials" in said
    assert "died with <Signals.SIGKILL: 9>" in said
    make_trials(copy)
    assert copy.bytes() == expected


def jobs_of(run, script):
    """The processes of a run that run a script, of which Snakemake makes a copy for each."""
    found = []
    for child in psutil.Process(run.pid).children(recursive=True):
        with suppress(psutil.Error):  # it has ended meanwhile
            found += [child] if script_of(child) == script else []
    return found


def test_a_clock_that_was_set_back_stops_a_run_with_the_remedy(copy):
    expected = copy.bytes()
    os.utime(copy.results / PART, (time.time() + 3600,) * 2)
    (copy.results / TRIALS).unlink()
    said = refused(copy)
    assert f"results/{PART} and 0 more are dated in the future: the clock was set back" in said
    remedy = "find -L results -newermt now -exec touch {} +"
    assert remedy in said
    subprocess.run(remedy.split(), cwd=copy.folder, check=True)
    make_trials(copy)
    assert copy.bytes() == expected


def test_times_in_disorder_make_nothing_again_whose_inputs_are_the_same(copy):
    """Contents of files up to a megabyte count; larger ones and folders are the oldest here."""
    rng, now = np.random.default_rng(0), time.time()
    tables = list(copy.results.rglob("*.parquet"))
    for path in [*tables, *copy.results.rglob(".snakemake_timestamp")]:
        by_time = path not in tables or path.stat().st_size > 1e6
        os.utime(path, (0 if by_time else now - rng.uniform(0, 1e6),) * 2)
    assert copy.planned(f"results/{TRIALS}") == {}


def test_a_second_run_in_the_same_folder_is_refused_and_the_first_goes_on(copy, tmp_path):
    expected = copy.bytes()
    (copy.results / TRIALS).unlink()
    (tmp_path / "sitecustomize.py").write_text(WAITING.format(file=str(tmp_path / "refused")))
    path = os.pathsep.join([str(tmp_path), copy.environment["PYTHONPATH"]])
    words = ["--cores", 1, f"results/{TRIALS}"]
    with ThreadPoolExecutor() as pool:
        first = pool.submit(copy.make, *words, PYTHONPATH=path)
        locks = copy.folder / ".snakemake" / "locks"
        while not (first.done() or any(locks.glob("*"))):
            time.sleep(0.05)
        said = refused(copy)
        (tmp_path / "refused").touch()
        first.result()
    assert "no other Snakemake process is trying to create the same files" in said
    assert "--unlock" in said
    assert copy.bytes() == expected
