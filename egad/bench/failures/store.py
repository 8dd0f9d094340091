"""Storage of a running search, so that it can be resumed after an interruption."""

import hashlib
import inspect
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from egad.bench.failures.parameters import FailureParameters
from egad.detectors import Detect, DetectorConfig, fingerprint
from egad.errors import UserError
from egad.tables import parquet
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS


class Found(NamedTuple):
    """What a search has found: tables of `tables.failures.EXAMINED` and `FAILURE_ATTEMPTS`."""

    examined: pd.DataFrame
    attempts: pd.DataFrame


NOTHING = Found(parquet.empty(EXAMINED), parquet.empty(FAILURE_ATTEMPTS))


def joined(found: Sequence[Found]) -> Found:
    """The tables of several steps or shards as one."""
    return Found(*(pd.concat(tables, ignore_index=True) for tables in zip(*found, strict=True)))


class Store:
    """A folder with the shards of one search: `shard-N/`."""

    def __init__(
        self, folder: Path, archive: pd.DataFrame, detect: Detect, settings: FailureParameters
    ) -> None:
        """Use a folder, which need not exist; UserError if it holds another search."""
        self.folder = folder
        self._search = {
            "settings": settings.model_dump(mode="json"),
            "detector": _fingerprint(detect),
            "objects": _checksum("".join(archive["id"])),
        }
        for path in self._tables():
            known = parquet.notes(path)
            if changed := [key for key, value in self._search.items() if known.get(key) != value]:
                raise UserError(
                    f"{folder} holds another search (other {', '.join(changed)}); choose another "
                    "folder, or delete this one"
                )

    def read(self, shard: int) -> Found:
        """What a shard has written, if anything."""
        path = self.folder / f"shard-{shard}"
        if not (path / "examined.parquet").is_file():
            return NOTHING
        examined = parquet.read(path / "examined.parquet", EXAMINED)
        attempts = parquet.read(path / "attempts.parquet", FAILURE_ATTEMPTS)
        # an older table of objects may be next to a newer one of attempts
        return Found(examined, attempts[attempts["id"].isin(set(examined["id"]))])

    def write(self, shard: int, found: Found) -> None:
        """Write what a shard has found so far."""
        path = self.folder / f"shard-{shard}"
        if len(found.examined):
            parquet.write(found.attempts, FAILURE_ATTEMPTS, path / "attempts.parquet")
            parquet.write(found.examined, EXAMINED, path / "examined.parquet", self._search)

    @contextmanager
    def named_in_errors(self) -> Iterator[None]:
        """Make user errors within the block say where the results so far are."""
        try:
            yield
        except UserError as error:
            if self._tables():
                error.args = (
                    f"{error}\nThe results so far are in {self.folder}; the same search resumes "
                    "from there",
                )
            raise

    def _tables(self) -> list[Path]:
        return sorted(self.folder.glob("shard-*/examined.parquet"))


def _fingerprint(detect: Detect) -> list[str]:
    """What identifies a detector, including its code and weights."""
    if isinstance(detect, DetectorConfig):
        return [detect.model_dump_json(), *fingerprint(detect)]
    named = detect if inspect.isroutine(detect) else type(detect)
    try:
        source = inspect.getsource(named)
    except (OSError, TypeError):  # raised for code that is not in a file
        source = ""
    return [f"{named.__module__}.{named.__qualname__}", _checksum(source)]


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
