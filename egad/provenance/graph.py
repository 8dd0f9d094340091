"""The origin of files, and of everything that they were made from, as plain values."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from egad.provenance.lookup import Noted, is_near, origin_of
from egad.tables.origin import ELSEWHERE


def provenance_graph(paths: Iterable[Path], folder: Path) -> dict[str, dict[str, Any]]:
    """The recorded origin of files and folders, and of all that they were made from, by path.

    Paths are relative to the folder. An origin is the stage, version and fingerprint of the code,
    hash of the settings, seed, arguments, and inputs with their SHA-256. Inputs without a record,
    and those outside the working directory, have no entry. Raises `TableError` or `UserError` if a
    table or a record is damaged.
    """
    found: dict[str, dict[str, Any]] = {}
    waiting = list(paths)
    while waiting:
        path = waiting.pop()
        name = _relative(path, folder)
        if name in found or not is_near(path, [Path.cwd(), folder]):
            continue
        noted = origin_of(path)
        if noted:
            found[name] = _entry(noted, folder)
            waiting.extend(source for source, _ in noted.sources())
    return dict(sorted(found.items()))


def _entry(noted: Noted, folder: Path) -> dict[str, Any]:
    values = noted.model_dump(exclude={"path", "inputs"})
    return values | {"inputs": {_relative(path, folder): sha for path, sha in noted.sources()}}


def _relative(path: Path, folder: Path) -> str:
    return str(path) if str(path).startswith(ELSEWHERE) else os.path.relpath(path, folder)
