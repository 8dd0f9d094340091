"""How long Snakemake plans, for studies/scaling/README.md.

    python tests/benchmarks/job_graph.py FOLDER

Dry runs of the whole pipeline: from an archive, where the graph depends on the shards alone, and
from folders of so many (empty) mesh files. A line each: jobs, CPU seconds, peak megabytes.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
OBJECTS = (10_000, 100_000)
SHARDS = (8, 32, 128, 1024)


Dataset = dict[str, str]


def mesh_folder(folder: Path, objects: int) -> Dataset:
    """A dataset of empty mesh files."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(objects):
        (folder / f"object-{number:06d}.stl").touch()
    return {"source": "meshes", "folder": str(folder), "units": "mm"}


def plan(folder: Path, dataset: Dataset, shards: int) -> tuple[int, float, float]:
    """Jobs, CPU seconds and peak megabytes of a dry run."""
    targets = {"datasets": ["mine"], "exports": ["dexnet", "acronym"], "agreement": True}
    settings = {"shards": shards, "datasets": {"mine": dataset}, "targets": targets}
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings))
    snakemake = [sys.executable, "-m", "snakemake", "--dry-run", "--quiet", "rules"]
    where = ["--snakefile", ROOT / "Snakefile", "--directory", folder, "--replace-workflow-config"]
    command = [*snakemake, *where, "--configfile", folder / "settings.yaml"]
    with (folder / "plan.txt").open("w") as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
    said = (folder / "plan.txt").read_text()
    if status:
        raise RuntimeError(said[-2000:])
    total = re.search(r"^total +(\d+)", said, re.MULTILINE)
    spent = used.ru_utime + used.ru_stime
    return int(total[1]) if total else 0, spent, used.ru_maxrss / 1024


def main(folder: Path, shards: list[int]) -> None:
    """Print a table."""
    folder.mkdir(parents=True, exist_ok=True)
    datasets: dict[str, Dataset] = {"an archive": {"source": "archive", "archive": "released"}}
    datasets |= {f"{n:,} meshes": mesh_folder(folder / str(n), n) for n in OBJECTS}
    print("| objects from | shards | jobs | CPU s | peak MB |\n| --- | --- | --- | --- | --- |")
    for name, dataset in datasets.items():
        for count in shards:
            jobs, cpu, megabytes = plan(folder, dataset, count)
            print(f"| {name} | {count} | {jobs:,} | {cpu:.1f} | {megabytes:.0f} |", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), [int(word) for word in sys.argv[2:]] or list(SHARDS))
