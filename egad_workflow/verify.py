"""Whether files are unchanged, by their own hashes and those recorded in files made from them."""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from egad.errors import TableError, UserError
from egad.io import SUMS, SUMS_ENDING, checksum, files_of, read_sums
from egad.tables.seal import is_whole
from egad_workflow.provenance import TABLE, is_near, origin_of

Found = Iterator[tuple[Path, str]]  # files, and what is wrong with them; empty if nothing is
UNSEALED = "no provenance recorded: not written by egad, or by an older version"


@dataclass(frozen=True)
class Verdict:
    """What was found."""

    checked: int  # how many files were compared with a hash
    problems: dict[Path, str]  # what is wrong, for each file that is not as it was made
    unknown: list[Path]  # files without a record
    gone: int  # inputs that no longer exist, or lie in neither the folder nor the working directory


def verify(folder: Path) -> Verdict:
    """Compare all files of a folder, except hidden ones, with every hash recorded for them."""
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder")
    files = [*files_of(folder), *(path for path in [folder / SUMS] if path.is_file())]
    records = [path for path in files if path.name == SUMS or path.suffix == SUMS_ENDING]
    tables = [path for path in files if path.suffix == TABLE]
    digest = cache(checksum)
    found = [*_tables(tables), *_others(records, digest)]
    if not found:
        raise UserError(f"{folder}: no provenance recorded for any file")
    altered = {path for path, problem in found if problem}
    sources = _sources([*(path for path in tables if path not in altered), *map(_made, records)])
    walked = {os.path.normpath(each) for path in files for each in (path, path.parent)}
    there = {
        source
        for _, source, _ in sources
        if str(source) in walked or is_near(source, (folder, Path.cwd()))
    }
    chained = [
        (path, f"made from a different version of {source}")
        for path, source, value in sources
        if source in there and digest(source) != value
    ]
    problems: dict[Path, str] = {}
    for path, problem in [*found, *chained]:
        if problem:
            problems.setdefault(path, problem)
    known = {path for path, _ in found}
    return Verdict(
        checked=len(known),
        problems=problems,
        unknown=[path for path in files if path not in known | set(records)],
        gone=len({source for _, source, _ in sources} - there),
    )


def _tables(paths: Iterable[Path]) -> Found:
    for path in paths:
        whole = is_whole(path)
        yield path, UNSEALED if whole is None else "" if whole else "altered"


def _others(records: Iterable[Path], digest: Callable[[Path], str]) -> Found:
    """The files that checksum files list, and those beside them that they do not list."""
    for record in records:
        try:
            sums = read_sums(record)[0]
        except UserError:
            yield record, "altered: not a checksum file"
            continue
        for path, value in sums.items():
            same = path.is_file() and digest(path) == value
            yield path, "" if same else "altered" if path.is_file() else "deleted"
        for path in files_of(record.parent) if record.name == SUMS else []:
            if path not in sums:
                yield path, "added: not among the files that were written here"


def _sources(paths: Iterable[Path]) -> list[tuple[Path, Path, str]]:
    """Files, an input of each, and its recorded hash; damaged files are skipped."""
    found = []
    for path in paths:
        try:
            noted = origin_of(path)
        except (TableError, UserError):
            continue
        found += [(path, *source) for source in (noted.sources() if noted else [])]
    return found


def _made(record: Path) -> Path:
    """The file or folder that a checksum file describes."""
    return record.parent if record.name == SUMS else record.with_suffix("")
