"""The manual of the results, `results/README.md`: every file, and the columns of every table.

`python -m egad.workflow.results_page` writes it; `--check` checks whether it is up to date.
"""

import sys
from collections import Counter
from collections.abc import Iterable
from importlib import import_module
from itertools import chain
from pathlib import Path
from pkgutil import iter_modules

import pyarrow as pa

from egad import tables
from egad._util.files import write_text
from egad._util.markdown import table
from egad.tables.columns import Result, meaning_of

PAGE = Path("results/README.md")
SHARED = "Columns of several tables"
MIN_SHARED = 3  # a column of this many tables is explained once
# Results that no module of tables lists.
OTHERS = [
    Result("report.html", "overview of all results; works offline"),
    Result("D/exchange/G.hdf5", "Dex-Net database (`targets.exports`); see docs/exchange.md"),
    Result(
        "D/exchange/G-FORMAT/",
        "exports in the formats of `targets.exports` other than dexnet",
    ),
]

Row = tuple[str, str, str, str]  # names, type, unit, meaning

INTRODUCTION = """# Results

The files of a run, where `D` is a dataset, `G` a gripper and `P` a grasp detector. Every table can
be read with `pandas.read_parquet`; its columns carry their `unit` and `meaning` as Arrow field
metadata. Lengths are in metres and masses in kilograms unless a unit says otherwise. Cells are
numbered from 0, the simplest and the easiest.

`egad provenance FILE` shows what a file was made from, and `egad verify results` whether anything
was altered since: [docs/provenance.md](../docs/provenance.md). `D/parts` and `D/epochs` hold files
that jobs pass to each other; the pipeline makes them again when it needs them.
"""


def results() -> list[Result]:
    """What a run writes: `FILES` of every module of tables, and the others, by path."""
    names = [f"{tables.__name__}.{each.name}" for each in iter_modules(tables.__path__)]
    listed = [getattr(import_module(name), "FILES", []) for name in names]
    return sorted([*OTHERS, *chain.from_iterable(listed)], key=lambda each: each.path)


def page() -> str:
    """The manual as Markdown."""
    listed = results()
    files = [(f"`{each.path}`", each.meaning) for each in listed]
    paths: dict[tuple[Row, ...], list[str]] = {}
    for each in listed:
        if each.columns is not None:
            paths.setdefault(tuple(_rows(each.columns)), []).append(f"`{each.path}`")
    counts = Counter(chain.from_iterable(paths))
    shared: dict[str, Row] = {}  # of each name the most common meaning
    for row, count in counts.most_common():
        if count >= MIN_SHARED:
            shared.setdefault(row[0], row)
    parts = [INTRODUCTION, table(["file", "what it is"], files)]
    parts.append(f"## {SHARED}\n\n{_table(shared.values())}")
    for rows, names in paths.items():
        parts.append(f"## {', '.join(names)}\n\n{_section(rows, {*shared.values()})}")
    return "\n".join(parts)


def _section(rows: tuple[Row, ...], shared: set[Row]) -> str:
    """The columns of a table, those of several tables by name only."""
    known = ", ".join(row[0] for row in rows if row in shared)
    link = f"[{SHARED}](#{SHARED.lower().replace(' ', '-')}): {known}.\n" if known else ""
    own = [row for row in rows if row not in shared]
    return "\n".join(filter(None, [link, _table(own) if own else ""]))


def _table(rows: Iterable[Row]) -> str:
    return table(["column", "type", "unit", "meaning"], rows)


def _rows(schema: pa.Schema) -> list[Row]:
    """Names, type, unit and meaning of the columns; those of a vector are one row."""
    names: dict[Row, list[str]] = {}
    for field in schema:
        meaning, unit = meaning_of(field)
        stem, _, part = field.name.rpartition("_")
        key = stem or field.name, str(field.type), unit, meaning.removesuffix(f", {part}")
        names.setdefault(key, []).append(field.name)
    rows = []
    for (_, kind, unit, meaning), (first, *others) in names.items():
        parts = [f"`_{each.rpartition('_')[2]}`" for each in others]
        rows.append((", ".join([f"`{first}`", *parts]), kind, unit, meaning))
    return rows


def main() -> None:
    """Write the manual or, with `--check`, check whether it is up to date."""
    if "--check" not in sys.argv:
        write_text(PAGE, page())
    elif PAGE.read_text(encoding="utf-8") != page():
        sys.exit(f"{PAGE} is out of date: run python -m egad.workflow.results_page")


if __name__ == "__main__":
    main()
