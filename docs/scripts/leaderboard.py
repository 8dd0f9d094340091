"""The tables of egad's own entries in leaderboard/: made again when the simulation has changed.

`python docs/scripts/leaderboard.py` makes those that are missing; delete one to make it again.
Those of published networks need their weights: `studies/published/published.py` makes them.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import egad
from egad.detectors.parameters import SHIPPED
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad_workflow.leaderboard import ENTRIES, ENTRY, PROTOCOLS, read_entry, read_protocol

FOLDER = Path(__file__).parents[2] / "leaderboard"


def make(detector: str, path: Path, out: Path, jobs: int) -> None:
    """Run a detector under the protocol of a file."""
    protocol, settings = read_protocol(path)
    gripper, trials = settings.targets.grippers[0], settings.trials
    if protocol.is_clutter:
        words = ["benchmark", detector, "--gripper", gripper, "--config", path, "--out", out]
        command = [sys.executable, "-m", "egad", *map(str, words), "--jobs", str(jobs)]
        subprocess.run(command, check=True)  # noqa: S603 (ours)
        return
    options = trials.model_dump(
        include={"attempts", "reset", "depth_noise", "contact", "stopping_force", "engine"}
    )
    objects = egad.load("evaluation-set")
    made = egad.run_trials(
        detector, objects, gripper, **options, errors=trials.errors, seed=settings.seed, jobs=jobs
    )
    parquet.write(made.table, TRIALS, out)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    for path in sorted((FOLDER / ENTRIES).glob(f"*/{ENTRY}")):
        entry = read_entry(path)
        if entry.detector not in SHIPPED:
            continue
        for name in entry.protocols:
            table = path.with_name(f"{name}.parquet")
            if not table.exists():
                make(entry.detector, FOLDER / PROTOCOLS / f"{name}.yaml", table, given.jobs)
                print(table, flush=True)
