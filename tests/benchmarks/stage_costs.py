"""What every stage costs, for docs/scaling.md: CPU time and memory of all jobs, without evolution.

    python tests/benchmarks/stage_costs.py run FOLDER OBJECTS   on so many of the released objects
    python tests/benchmarks/stage_costs.py table FOLDER...      a table of such runs

What follows `run FOLDER OBJECTS` goes to Snakemake, e.g. `-- results/egad/eval49.parquet`.
Benchmark files of Snakemake are samples, every half second and later every half minute: what a job
did after the last is missing. Here every `egad` of a rule is waited for, and what the system says
that it and its children have used goes into `costs.tsv`.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from egad.data import released
from egad.random import generator
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE

ROOT = Path(__file__).parents[2]
SETTINGS = {"shards": 2, "targets": {"exports": ["dexnet", "acronym"], "agreement": True}}


def run(folder: Path, objects: int, extra: list[str]) -> None:
    """Run the pipeline on one core, on released objects drawn by chance."""
    folder.mkdir(parents=True)
    parquet.write(drawn(objects), ARCHIVE, folder / "some.parquet", parquet.notes(released()))
    dataset = {"source": "archive", "archive": "some.parquet"}
    settings = {**SETTINGS, "datasets": {"egad": dataset}}
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings))
    # bash reads this file before each command of a rule
    measured = f'"{sys.executable}" "{Path(__file__).resolve()}" job "{folder.resolve()}/costs.tsv"'
    (folder / "measured.sh").write_text(f'egad() {{ {measured} "$@"; }}\n')
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "1", "--directory", folder]
    files = ["--snakefile", ROOT / "Snakefile", "--configfile", folder / "settings.yaml"]
    environment = {**os.environ, "BASH_ENV": str(folder.resolve() / "measured.sh")}
    subprocess.run([*snakemake, *files, *extra], env=environment, check=True)


def drawn(objects: int) -> pd.DataFrame:
    """Some of the released objects; the fewer are among the more."""
    archive = parquet.read(released(), ARCHIVE)
    chosen = generator(0, "scaling").permutation(len(archive))[:objects]
    return archive.iloc[np.sort(chosen)].reset_index(drop=True)


def job(costs: Path, arguments: list[str]) -> int:
    """Call `egad` with these arguments and book what it took; returns its exit status."""
    process = subprocess.Popen(["egad", *arguments])
    _, status, used = os.wait4(process.pid, 0)
    stage = arguments[0]
    if stage in ("join", "export"):
        stage += f" {Path(arguments[arguments.index('--out') + 1]).name}"
    spent = used.ru_utime + used.ru_stime
    with costs.open("a") as file:
        file.write(f"{stage}\t{spent:.2f}\t{used.ru_maxrss / 1024:.0f}\n")
    return os.waitstatus_to_exitcode(status)


def costs_of(folder: Path) -> pd.DataFrame:
    """CPU seconds of all jobs and peak megabytes of the largest, by stage."""
    jobs = pd.read_csv(folder / "costs.tsv", sep="\t", names=["stage", "cpu", "mb"])
    return jobs.groupby("stage", sort=False).agg({"cpu": "sum", "mb": "max"})


def table(folders: list[Path]) -> str:
    """CPU seconds / peak megabytes of each stage in each run."""
    runs = [costs_of(folder) for folder in folders]
    stages = list(dict.fromkeys(stage for each in runs for stage in each.index))
    lines = ["| stage | " + " | ".join(folder.name for folder in folders) + " |"]
    lines.append("| --- " * (len(runs) + 1) + "|")
    for stage in stages:
        cells = [
            f"{each.at[stage, 'cpu']:.1f} / {each.at[stage, 'mb']}" if stage in each.index else ""
            for each in runs
        ]
        lines.append(f"| {stage} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    command, first, *rest = sys.argv[1:]
    if command == "job":
        sys.exit(job(Path(first), rest))
    if command == "run":
        run(Path(first), int(rest[0]), rest[1:])
    else:
        print(table([Path(first), *map(Path, rest)]))
