"""The origin of a file or folder: in a table itself, or beside any other file."""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from egad import __version__
from egad.errors import UserError
from egad.io import SUMS, checksum, read_sums, sums_path
from egad.tables import parquet
from egad.tables.origin import ELSEWHERE, Origin, made_by

TABLE = ".parquet"


@contextmanager
def recorded(
    stage: str,
    *,
    code: str = "",
    settings: BaseModel | Mapping[str, Any] | None = None,
    arguments: Mapping[str, Any] | None = None,
    inputs: Iterable[Path] = (),
) -> Iterator[None]:
    """Record the origin of whatever is written in the block, by a rule or command: all but None."""
    values = _plain(settings or {})
    origin = Origin(
        program=__version__,
        stage=stage,
        code=code,
        settings=settings_hash(values) if values else None,
        seed=values.get("seed"),
        arguments={name: each for name, each in (arguments or {}).items() if each is not None},
        inputs=tuple((path, checksum(path)) for path in inputs if path.exists()),
    )
    with made_by(origin):
        yield


def settings_hash(settings: BaseModel | Mapping[str, Any]) -> str:
    """A fingerprint of settings: 16 hexadecimal digits."""
    text = json.dumps(_plain(settings), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(settings: BaseModel | Mapping[str, Any]) -> Mapping[str, Any]:
    return settings.model_dump(mode="json") if isinstance(settings, BaseModel) else settings


class Noted(BaseModel):
    """An `egad.tables.origin.Origin` as it was recorded for a file or folder."""

    path: Path
    program: str
    stage: str
    code: str
    settings: str | None
    seed: int | None
    arguments: dict[str, Any]
    inputs: list[tuple[str, str]]

    def sources(self) -> list[tuple[Path, str]]:
        """The inputs where they should be now, with hashes; nowhere if they are from elsewhere."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return [
            (Path(name if name.startswith(ELSEWHERE) else os.path.normpath(folder / name)), digest)
            for name, digest in self.inputs
        ]


def is_near(path: Path, folders: Iterable[Path]) -> bool:
    """Whether a path is in one of some folders, links followed: others may be devices or disks."""
    kinds = (os.path.isfile, os.path.isdir)  # unlike those of `Path`, they take any text
    if not any(is_kind(path) for is_kind in kinds):
        return False
    return any(path.resolve().is_relative_to(folder.resolve()) for folder in folders)


def origin_of(path: Path) -> Noted | None:
    """The recorded origin of a file or folder, if any; `TableError` or `UserError` if damaged."""
    if path.suffix == TABLE:
        values = parquet.origin_of(path)
    else:
        files = [file for file in (sums_path(path), path.parent / SUMS) if file.is_file()]
        values = read_sums(files[0])[1] if files else {}
    try:
        return Noted.model_validate({**values, "path": path}) if values else None
    except (ValidationError, TypeError) as error:
        raise UserError(f"{path}: its provenance record is damaged") from error


def provenance_graph(paths: Iterable[Path], folder: Path) -> dict[str, dict[str, Any]]:
    """The recorded origin of files, folders and all that they were made from, by relative path."""
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
