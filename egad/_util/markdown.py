"""Tables in Markdown."""

from collections.abc import Iterable, Sequence
from typing import Any


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown with a trailing newline; whole numbers have commas."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(map(_cell, line))} |\n" for line in lines)


def _cell(value: Any) -> str:  # noqa: ANN401 (whatever is told)
    return f"{value:,}" if isinstance(value, int) and not isinstance(value, bool) else str(value)
