"""CPU hours of the jobs of a run, by rule: `python experiments/cost.py RUN/benchmarks`."""

import sys
from pathlib import Path

import pandas as pd
from cluster import job


def main(folder: Path) -> None:
    """Print the table."""
    jobs = pd.concat([job(path) for path in sorted(folder.rglob("*.tsv"))])
    hours = jobs.groupby("rule")["cpu_time"].agg(["count", "sum"])
    print("| rule | jobs | CPU hours |\n| --- | --- | --- |")
    for rule, (count, seconds) in hours.iterrows():
        print(f"| {rule} | {count:.0f} | {seconds / 3600:.1f} |")
    print(f"| all | {len(jobs)} | {jobs['cpu_time'].sum() / 3600:.1f} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
