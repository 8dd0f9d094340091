"""The chart and the table of labels in docs/trials.md: `python docs/agreement.py TABLE`."""

import string
import sys
from pathlib import Path

from egad.files import write_text
from egad.report.agreement_view import agreement
from egad.settings import Settings
from egad.tables import parquet
from egad.tables.evaluation import AGREEMENT
from egad.trials.ranking import Area

HERE = Path(__file__).parent


def main(path: Path) -> None:
    """Write the chart beside this file and print the table."""
    rows = Settings().select_eval.rows
    found = agreement(parquet.read(path, AGREEMENT), rows)
    write_text(HERE / "agreement.svg", found.svg)
    print(f"{found.free} of {found.labelled} free; {found.outcomes}; {found.rate}")
    names = [*string.ascii_uppercase[:rows], "all"]
    print("| | " + " | ".join(found.areas) + " |")
    print("| --- " * (len(found.areas) + 1) + "|")
    for name, areas in zip(names, zip(*found.areas.values(), strict=True), strict=True):
        print(f"| {name} | " + " | ".join(map(text, areas)) + " |")


def text(area: Area) -> str:
    """The area and its interval."""
    low, high = area.interval
    return f"{area.value:.2f} ({low:.2f} to {high:.2f})"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
