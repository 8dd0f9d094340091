"""What every stage costs: CPU time and memory of all jobs but evolution (studies/scaling).

    python tests/benchmarks/stage_costs.py run FOLDER OBJECTS   on so many of the released objects
    python tests/benchmarks/stage_costs.py table FOLDER...      a table of such runs

What follows `run FOLDER OBJECTS` goes to Snakemake, e.g. `-- results/egad/eval49.parquet`.
Benchmark files of Snakemake are samples, every half second and later every half minute: what a job
did after the last is missing. Here every script of a rule writes what the system says that it and
its children have used into `costs.tsv` when it ends.
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
MEASURED = """
import atexit, re, resource, sys
from pathlib import Path


def book():
    job = getattr(sys.modules["__main__"], "snakemake", None)
    if job is not None:
        own, others = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        spent = sum(each.ru_utime + each.ru_stime for each in (own, others))
        # not own.ru_maxrss, which counts from before Snakemake's process became this one
        peak = int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
        most = max(peak, others.ru_maxrss) / 1024
        with open({costs!r}, "a") as file:
            file.write(f"{{job.rule}}\\t{{spent:.2f}}\\t{{most:.0f}}\\n")


atexit.register(book)
"""
SETTINGS = {"shards": 2, "targets": {"exports": ["dexnet", "acronym"], "agreement": True}}


def run(folder: Path, objects: int, extra: list[str]) -> None:
    """Run the pipeline on one core, on released objects drawn by chance."""
    folder.mkdir(parents=True)
    parquet.write(drawn(objects), ARCHIVE, folder / "some.parquet", parquet.notes(released()))
    dataset = {"source": "archive", "archive": "some.parquet"}
    settings = {**SETTINGS, "datasets": {"egad": dataset}}
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings))
    (folder / "measured").mkdir()
    # Python imports a module of this name when it starts
    code = MEASURED.format(costs=str(folder.resolve() / "costs.tsv"))
    (folder / "measured/sitecustomize.py").write_text(code)
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "1", "--directory", folder]
    files = ["--snakefile", ROOT / "Snakefile", "--configfile", folder / "settings.yaml"]
    paths = [str(folder.resolve() / "measured"), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    subprocess.run([*snakemake, *files, *extra], env=environment, check=True)


def drawn(objects: int) -> pd.DataFrame:
    """Some of the released objects; the fewer are among the more."""
    archive = parquet.read(released(), ARCHIVE)
    chosen = generator(0, "scaling").permutation(len(archive))[:objects]
    return archive.iloc[np.sort(chosen)].reset_index(drop=True)


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
    if command == "run":
        run(Path(first), int(rest[0]), rest[1:])
    else:
        print(table([Path(first), *map(Path, rest)]))
