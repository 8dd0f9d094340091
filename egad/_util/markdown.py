"""Pages and tables in Markdown."""

from collections.abc import Iterable, Sequence
from importlib.resources import files
from typing import Any


def filled(package: str, name: str, /, **values: Any) -> str:  # noqa: ANN401 (whatever is told)
    """A Markdown file of a package with a value for each `{name}`, ending in one newline."""
    text = files(package).joinpath(name).read_text("utf-8")
    return text.format(**values).rstrip("\n") + "\n"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown with a trailing newline; whole numbers have commas."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(map(_cell, line))} |\n" for line in lines)


def _cell(value: Any) -> str:  # noqa: ANN401 (whatever is told)
    return f"{value:,}" if isinstance(value, int) and not isinstance(value, bool) else str(value)
