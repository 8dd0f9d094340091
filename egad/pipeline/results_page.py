"""The manual of the results, `results/README.md`, and the table of stages in `docs/pipeline.md`.

The manual says what the stages declare (`egad.pipeline.parameters`): paths and columns, with the
docstring of each parameter. The table says what stands at the head of the files of rules.
`python -m egad.pipeline.results_page` writes both, `--check` says whether they are up to date.
"""

import ast
import importlib
import pkgutil
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from egad._util.files import write_text
from egad._util.markdown import table
from egad.pipeline import exports, stages
from egad.pipeline.cli.stages import described
from egad.pipeline.parameters import Output, declared
from egad.tables.columns import markdown_table

PAGE = Path("results/README.md")
TABLE = Path("docs/pipeline.md")
RULES = Path("workflow/rules")
BETWEEN = re.compile(r"(?<=<!-- stages -->\n).*?(?=<!-- end -->)", re.DOTALL)


class Artefact(NamedTuple):
    """Files that a parameter of a stage names: what they are, and what tables among them hold."""

    outputs: list[Output]
    meaning: str


INTRODUCTION = """# Results

A run writes these files for a dataset `D`, a gripper `G` and a grasp detector `P`. Every table
opens with `pandas.read_parquet`. Columns carry their `unit` and `meaning` as Arrow field metadata.

Lengths are metres and masses kilograms unless a unit says otherwise. Cells count from 0 = simplest
and 0 = easiest, while `difficulty` itself is a grasp quality: high for easy objects. With measures
of your own (`measures` in the settings), `complexity` and `difficulty` hold their values, and
`grasps` is 0.

`egad provenance FILE` shows what a file was made from, and `egad verify results` whether anything
was altered since. For that, folders have a `SHA256SUMS`, and files that are not tables a
`NAME.sha256`. See `docs/provenance.md`.

The folders `D/parts` and `D/epochs` hold what jobs pass to each other. You may delete them once a
run is finished. The pipeline makes what it needs again, which for more epochs is all of them.

This page is generated from what the stages declare: `python -m egad.pipeline.results_page`.
"""


def artefacts() -> list[Artefact]:
    """All files of the results that stages declare, in the order of their paths."""
    modules = [
        importlib.import_module(f"{package.__name__}.{found.name}")
        for package in (stages, exports)
        for found in pkgutil.iter_modules(package.__path__)
    ]
    functions = {
        function
        for module in modules
        for function in vars(module).values()
        if getattr(function, "__module__", "") == module.__name__ and hasattr(function, "__code__")
    }
    found = [
        Artefact(outputs, described(function)[each.name])
        for function in functions
        for each in declared(function)
        if (outputs := [output for output in each.outputs if output.path])
    ]
    return sorted(found, key=lambda artefact: artefact.outputs[0].path)


def page() -> str:
    """The manual as Markdown."""
    return "\n".join([INTRODUCTION, *map(_section, artefacts())])


def _section(artefact: Artefact) -> str:
    paths = ", ".join(f"`{output.path}`" for output in artefact.outputs)
    lines = [f"## {paths}", "", f"{artefact.meaning}.", ""]
    for output in artefact.outputs:
        if output.schema is None:
            continue
        if len(artefact.outputs) > 1:
            lines += [f"`{output.path}`:", ""]
        lines.append(markdown_table(output.schema))
    return "\n".join(lines)


def stage_table() -> str:
    """What each file of rules makes and from what, as Markdown."""
    rows = [row for path in _rule_files() for row in _stage_row(path)]
    return table(["stage", "commands", "from", "makes"], rows)


def _rule_files() -> list[Path]:
    """The files of rules, in the order in which they are included."""
    text = (RULES.parent / "Snakefile").read_text(encoding="utf-8")
    return [RULES / name for name in re.findall(r'include: "rules/(\w+\.smk)"', text)]


def _stage_row(path: Path) -> Iterator[tuple[str, ...]]:
    """The row of a file of rules, unless it has only functions."""
    text = path.read_text(encoding="utf-8")
    head = " ".join(str(ast.literal_eval(text[: text.index('"""', 3) + 3])).split())
    parts = re.fullmatch(r"([\w-]+): (.*?)Inputs: (.*?)\. Outputs: (.*?)\.( Steps: .*)?", head)
    if parts is None:
        return
    commands = dict.fromkeys(re.findall(r"egad ([a-z][a-z-]*)", text))
    commands |= dict.fromkeys(["join"] if "use rule join" in text else [])
    shown = ", ".join(f"`egad {name}`" for name in commands)
    made_from, makes = (part.replace("results/D/", "D/") for part in (parts[3], parts[4]))
    yield parts[1].lower(), shown, made_from, makes


def files() -> dict[Path, str]:
    """The generated files and their text."""
    docs = TABLE.read_text(encoding="utf-8")
    return {PAGE: page(), TABLE: BETWEEN.sub(lambda _: stage_table(), docs)}


def main() -> None:
    """Write the files, or with `--check` say whether they are what the stages declare."""
    for path, text in files().items():
        if "--check" not in sys.argv:
            write_text(path, text)
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} is out of date: run python -m egad.pipeline.results_page")


if __name__ == "__main__":
    main()
