"""CPU hours of the jobs of a run, by rule: `python experiments/cost.py RUN/benchmarks`."""

import sys
from pathlib import Path

import pandas as pd
from cluster import job

from egad._util.markdown import table


def main(folder: Path) -> None:
    """Print the table."""
    jobs = pd.concat([job(path) for path in sorted(folder.rglob("*.tsv"))])
    hours = jobs.groupby("rule")["cpu_time"].agg(["count", "sum"])
    hours.loc["all"] = len(jobs), jobs["cpu_time"].sum()
    rows = [
        (rule, f"{count:.0f}", f"{time / 3600:.1f}") for rule, count, time in hours.itertuples()
    ]
    print(table(["rule", "jobs", "CPU hours"], rows))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
