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
    print(f"{found.free} of {found.labelled} free; {found.outcomes}")
    names = [*string.ascii_uppercase[:rows], "all"]
    print("| row | held | " + " | ".join(found.areas) + " |")
    print("| --- " * (len(found.areas) + 2) + "|")
    for name, rate, *areas in zip(names, found.rates, *found.areas.values(), strict=True):
        held = f"{rate.successes} of {rate.attempts}"
        print(f"| {name} | {held} | " + " | ".join(map(text, areas)) + " |")
    same = [f"{areas[-1].within:.2f}" for areas in found.areas.values()]
    print(f"| pairs of one object | | {' | '.join(same)} |")


def text(area: Area) -> str:
    """The area and its interval."""
    low, high = area.interval
    return f"{area.value:.2f} ({low:.2f} to {high:.2f})"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
