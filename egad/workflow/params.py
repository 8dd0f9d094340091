"""Parameters of rules, whose jobs run again when they change. For any Snakefile."""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from egad._util.parameters import Parameters
from egad.config.input_files import is_result
from egad.io import checksum


def plain(part: Parameters) -> dict[str, Any]:
    """Settings as tables of plain values.

    Whether a run continues after failures of a detector is left out: it changes no result.
    """
    return part.model_dump(
        mode="json", exclude={"trials": {"keep_going"}, "clutter": {"keep_going"}}
    )


def contents(files: Iterable[str]) -> str:
    """A checksum of inputs that are not results; an older file may have replaced them."""
    return _contents(tuple(file for file in files if not is_result(file)))


@cache
def _contents(files: tuple[str, ...]) -> str:
    sums = [checksum(Path(file)) for file in files if Path(file).exists()]
    return hashlib.sha256("".join(sums).encode()).hexdigest()[:16]
