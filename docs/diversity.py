"""The chart and the tables of docs/diversity.md: `python docs/diversity.py results.parquet`."""

import sys
from pathlib import Path

import pandas as pd

from egad.files import write_text
from egad.report.diversity_figures import success_chart
from egad.report.environment import p_value
from egad.tables import parquet
from egad.tables.training import COMPARED
from egad.trials.statistics import Rate, mean_rate
from egad.trials.training_sets import SetRate, by_set, references, set_pairs, set_rate

HERE = Path(__file__).parent


def main(path: Path) -> None:
    """Write the chart beside this file and print the tables."""
    table = parquet.read(path, COMPARED)
    tests = {str(name): rows for name, rows in table.groupby("test", sort=False)}
    rates = {
        name: {key: set_rate(own) for key, own in by_set(rows).items()}
        for name, rows in tests.items()
    }
    others = {
        name: {key: mean_rate(own) for key, own in references(rows).items()}
        for name, rows in tests.items()
    }
    write_text(HERE / "diversity.svg", success_chart(rates, others))
    for name, rows in tests.items():
        tell(name, rates[name], others[name])
        compare(rows)


def tell(test: str, rates: dict[str, SetRate], others: dict[str, Rate]) -> None:
    """Print the success of all sets in a test."""
    print(f"\n| success on {test}, % | all networks | each |\n| --- | --- | --- |")
    for name, found in rates.items():
        each = ", ".join(f"{100 * one.value:.0f}" for one in found.each.values())
        print(f"| `{name}` | {text(found.pooled)} | {each} |")
    for name, rate in others.items():
        print(f"| {name} | {text(rate)} | |")


def compare(rows: pd.DataFrame) -> None:
    """Print every pair of sets."""
    print("\n| pair | points | p | p, Holm |\n| --- | --- | --- | --- |")
    for pair in set_pairs(by_set(rows)):
        low, high = (100 * end for end in pair.result.interval)
        points = f"{100 * pair.result.difference:.0f} ({low:.0f} to {high:.0f})"
        numbers = f"{p_value(pair.result.p_objects)} | {p_value(pair.p_holm)}"
        print(f"| `{pair.first}` against `{pair.second}` | {points} | {numbers} |")


def text(rate: Rate) -> str:
    """A rate with its interval, percent."""
    low, high = (100 * end for end in rate.interval)
    return f"{100 * rate.value:.0f} ({low:.0f} to {high:.0f})"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
