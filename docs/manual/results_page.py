"""The manual of the results, `results/README.md`: every file, and the columns of every table."""

from collections import Counter
from importlib import import_module
from itertools import chain
from pathlib import Path
from pkgutil import iter_modules

import pyarrow as pa

from egad import tables
from egad._util.markdown import table
from egad.tables.columns import Result, meaning_of

PAGE = Path("results/README.md")
HEAD = ["column", "type", "unit", "meaning"]
MIN_SHARED = 3  # a column of this many tables is explained once, as in most of them
# Results that no module of tables lists.
OTHERS = [
    Result("report.html", "overview of all results; works offline"),
    Result("D/exchange/G.hdf5", "Dex-Net database (`targets.exports`); see docs/exchange.md"),
    Result("D/exchange/G-FORMAT/", "exports in other formats of `targets.exports`"),
]

Row = tuple[str, str, str, str]  # names, type, unit, meaning

INTRODUCTION = """# Results

The files of a run: `D` is a dataset, `G` a gripper and `P` a grasp detector. `pandas.read_parquet`
reads every table; its columns carry their `unit` and `meaning` as Arrow metadata. Lengths are in
metres and masses in kilograms unless a unit says otherwise. Cells count from 0, the simplest and
the easiest. `egad provenance FILE` shows what a file was made from, and `egad verify results`
whether anything was altered since ([provenance](../docs/provenance.md)). `D/parts` and `D/epochs`
hold files that jobs pass to each other.
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
    counts = Counter(chain.from_iterable(paths)).most_common()
    shared = {row[0]: row for row, count in reversed(counts) if count >= MIN_SHARED}.values()
    parts = [INTRODUCTION, table(["file", "what it is"], files)]
    parts.append(f"## Columns of several tables\n\n{table(HEAD, reversed(shared))}")
    for rows, names in paths.items():
        own = [row for row in rows if row not in shared]
        known = ", ".join(row[0] for row in rows if row in shared)
        link = f"[Columns of several tables](#columns-of-several-tables): {known}.\n\n"
        text = (link if known else "") + (table(HEAD, own) if own else "")
        parts.append(f"## {', '.join(names)}\n\n{text}")
    return "\n".join(parts)


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
