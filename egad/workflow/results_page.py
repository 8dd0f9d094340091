"""The manual of the results, `results/README.md`: every file, and the columns of every table.

`python -m egad.workflow.results_page` writes it; `--check` checks whether it is up to date.
"""

import sys
from importlib import import_module
from itertools import chain
from pathlib import Path
from pkgutil import iter_modules

from egad import tables
from egad._util.files import write_text
from egad._util.markdown import table
from egad.tables.columns import Result, markdown_table

PAGE = Path("results/README.md")
# Results that no module of tables lists.
OTHERS = [
    Result("report.html", "overview of all results; works offline"),
    Result("D/exchange/G.hdf5", "Dex-Net database (`targets.exports`); see docs/exchange.md"),
    Result(
        "D/exchange/G-FORMAT/",
        "exports in the formats of `targets.exports` other than dexnet",
    ),
]

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
    rows = [(f"`{each.path}`", each.meaning) for each in listed]
    parts = [INTRODUCTION, table(["file", "what it is"], rows)]
    known: dict[str, str] = {}
    for each in listed:
        if each.columns is not None:
            text = markdown_table(each.columns)
            known[text] = ", ".join(filter(None, [known.get(text), f"`{each.path}`"]))
    return "\n".join([*parts, *(f"## {paths}\n\n{text}" for text, paths in known.items())])


def main() -> None:
    """Write the manual or, with `--check`, check whether it is up to date."""
    if "--check" not in sys.argv:
        write_text(PAGE, page())
    elif PAGE.read_text(encoding="utf-8") != page():
        sys.exit(f"{PAGE} is out of date: run python -m egad.workflow.results_page")


if __name__ == "__main__":
    main()
