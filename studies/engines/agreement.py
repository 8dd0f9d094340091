"""The chart and the table of labels in README.md.

Run `python studies/engines/agreement.py TABLE`.
"""

import string
import sys
from pathlib import Path

import numpy as np

from egad._util.files import write_text
from egad.bench.stats import Area
from egad.report.agreement import agreement
from egad.tables import parquet
from egad.tables.evaluation import AGREEMENT
from egad_workflow.settings import Settings

FOLDER = Path(__file__).parent


def main(path: Path) -> None:
    """Write the chart beside this file and print the table."""
    rows = Settings().select_eval.rows
    found = agreement(parquet.read(path, AGREEMENT), rows)
    write_text(FOLDER / "agreement.svg", found.svg)
    print(f"{found.free} of {found.labelled} free; {found.outcomes}")
    names = [*string.ascii_uppercase[:rows], "all"]
    print("| row | held | objects with a failure | " + " | ".join(found.areas) + " |")
    print("| --- " * (len(found.areas) + 3) + "|")
    counts = zip(names, found.rates, found.failing, strict=True)
    for (name, rate, failing), *areas in zip(counts, *found.areas.values(), strict=True):
        held = f"{rate.successes} of {rate.attempts} | {failing}"
        print(f"| {name} | {held} | " + " | ".join(map(text, areas)) + " |")
    same = [f"{areas[-1].within:.2f}" for areas in found.areas.values()]
    print(f"| pairs of one object | | | {' | '.join(same)} |")
    print(f"robust less plain: {text(found.gain)}; in pairs of one object {found.gain.within:.2f}")


def text(area: Area) -> str:
    """The area and its interval, if it has one."""
    low, high = area.interval
    return f"{area.value:.2f}" + ("" if np.isnan(low) else f" ({low:.2f} to {high:.2f})")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
