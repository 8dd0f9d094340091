"""The section Cleared tables: how well detectors clear tables of several objects."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations

import pandas as pd

from egad.bench import CUSTOM
from egad.bench.stats import (
    Clearing,
    ClearingComparison,
    NothingInCommonError,
    Rate,
    by_difficulty,
    clearing_conclusion,
    clearing_rates,
    compare_clearing,
    engine_names,
    unusual,
)
from egad.report.page import data_uri, render_template
from egad.tables import parquet


@dataclass(frozen=True)
class ClutterView:
    """Cleared tables of one gripper; `thirds` by detector, axis and third of the objects."""

    engine: str
    rates: dict[str, list[Clearing]]
    thirds: dict[str, dict[str, list[tuple[Rate, Rate]]]]
    pictures: dict[str, list[str]]


def clutter_view(
    tables: Mapping[str, pd.DataFrame],
    objects: pd.DataFrame,
    pictures: Mapping[str, Sequence[bytes]],
) -> ClutterView:
    """What the section shows of `tables.clutter.CLUTTER` by detector, and PNGs by kind of scene."""
    return ClutterView(
        engine_names(pd.concat(tables.values())),
        {name: clearing_rates(table) for name, table in tables.items()},
        {name: _thirds(table, objects) for name, table in tables.items()},
        {kind: [data_uri(png) for png in each] for kind, each in pictures.items()},
    )


@dataclass(frozen=True)
class ClearingResults:
    """Detectors that cleared tables."""

    engines: dict[str, str]
    rates: dict[str, list[Clearing]]  # success rates in each kind of scene and noise, by detector
    # comparisons of every two detectors that cleared the same tables, by `A vs B`
    pairs: dict[str, list[ClearingComparison]]
    # rules by which the tables were cleared, and errors if any, by detector
    protocols: dict[str, str]
    conclusions: list[str]  # what the comparisons show, a sentence each

    @property
    def warning(self) -> str:
        """A warning about tables that were cleared by different rules; empty if there are none."""
        by_rules: dict[str, list[str]] = {}
        for name, rules in self.protocols.items():
            by_rules.setdefault(rules, []).append(name)
        if len(by_rules) < 2 and not any(CUSTOM in rules for rules in by_rules):
            return ""
        named = "; ".join(f"{rules}: {', '.join(names)}" for rules, names in by_rules.items())
        many = "are" if len(by_rules) > 1 else "may be"
        return (
            f"The rules {many} different ({named}): a difference between tables is then due to the "
            "rules, too, not only to the detectors"
        )


def clearing_results(tables: Mapping[str, pd.DataFrame]) -> ClearingResults:
    """Rates from `tables.clutter.CLUTTER` by detector; comparisons of those with common rounds."""
    pairs, conclusions = {}, []
    for one, other in combinations(tables, 2):
        with suppress(NothingInCommonError):
            compared = compare_clearing(tables[one], tables[other])
            pairs[f"{one} vs {other}"] = compared
            conclusions += [clearing_conclusion(one, other, each) for each in compared]
    engines = {name: engine_names(table) for name, table in tables.items()}
    rates = {name: clearing_rates(table) for name, table in tables.items()}
    rules = {
        name: ", ".join([*table["protocol"].unique(), *unusual(table, {"errors": "none"})])
        for name, table in tables.items()
    }
    return ClearingResults(engines, rates, pairs, rules, conclusions)


def page(results: ClearingResults) -> str:
    """An HTML page about cleared tables that needs no other file."""
    return render_template("clutter_page.html.j2", **vars(results), warning=results.warning)


def _thirds(table: pd.DataFrame, objects: pd.DataFrame) -> dict[str, list[tuple[Rate, Rate]]]:
    found: dict[str, list[tuple[Rate, Rate]]] = {}
    for row in parquet.records(by_difficulty(table, objects)):
        rates = tuple(Rate(row["successes"], row[of]) for of in ("attempts", "present"))
        found.setdefault(row["axis"], []).append((rates[0], rates[1]))
    return found
