"""Folders of mesh files: which are objects, and their names; archives with the same bytes."""

import difflib
import hashlib
import logging
import os
import re
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from pathlib import Path, PurePosixPath

from egad.errors import UserError
from egad.io.mesh import ENDINGS

log = logging.getLogger(__name__)

EVERY_FILE = "*"
_WILDCARD = re.compile(r"[*?\[]")
EARLIEST = (1980, 1, 1, 0, 0, 0)  # the earliest time that a ZIP archive can hold
READABLE = 0o100644 << 16  # a plain file that everybody may read
UNIX = 3


def files_below(folder: Path, above: frozenset[str] = frozenset()) -> Iterator[Path]:
    """All files in a folder and the folders in it, except hidden folders, sorted in each of them.

    Links are followed as `find -L` does, but not to a folder around them, among the real paths
    `above`. A folder that cannot be read is left out with a warning; `UserError` if it is the
    first.
    """
    try:
        entries = sorted(os.scandir(folder), key=attrgetter("name"))
    except OSError as error:
        if not above:
            raise UserError(f"{folder}: cannot be read: {error.strerror}") from error
        log.warning("%s is left out: it cannot be read: %s", folder, error.strerror)
        return
    within = above | {os.path.realpath(folder)}
    for entry in entries:
        if not os.path.isdir(entry.path):  # noqa: PTH112 (False where `Path.is_dir` raises)
            yield Path(entry.path)
        elif not entry.name.startswith(".") and os.path.realpath(entry.path) not in within:
            yield from files_below(Path(entry.path), within)


def mesh_files(folder: Path, pattern: str = EVERY_FILE) -> list[Path]:
    """The mesh files that match a glob in a folder, sorted, without hidden ones; or `UserError`."""
    _check_folder(folder)
    try:
        found = sorted(path for path in _matches(folder, pattern) if _is_mesh(path, folder))
    except (ValueError, IndexError, NotImplementedError) as error:
        raise UserError(f"pattern {pattern!r} is not valid: {error}") from error
    if not found:
        where = "in it" if pattern == EVERY_FILE else f"that match the pattern {pattern}"
        raise UserError(f"{folder}: no mesh files {where}; allowed endings: {' '.join(ENDINGS)}")
    return found


def _matches(folder: Path, pattern: str) -> Iterator[Path]:
    """What matches a pattern, on every version of Python: that of 3.11 follows no links in `**`."""
    kinds = PurePosixPath(pattern).parts
    if not any("**" in each for each in kinds):
        yield from folder.glob(pattern)
        return
    if [each for each in kinds if "**" in each] != ["**"]:
        raise ValueError("`**` is allowed only once, as the whole name of a folder")
    place = kinds.index("**")
    starts = folder.glob("/".join(kinds[:place])) if place else [folder]
    end = "/".join(kinds[place + 1 :]) or "*"
    for start in starts:
        above = (os.path.realpath(each) for each in start.parents if each.is_relative_to(folder))
        for path in files_below(start, frozenset(above)) if start.is_dir() else []:
            if path.relative_to(start).match(end):
                yield path


def _check_folder(folder: Path) -> None:
    try:
        os.scandir(folder).close()
    except (FileNotFoundError, NotADirectoryError) as error:
        if folder.is_file():
            raise UserError(f"{folder}: is a file, not a folder of meshes") from error
        raise UserError(f"{folder}: there is no such folder of meshes{_similar(folder)}") from error
    except OSError as error:
        raise UserError(f"{folder}: cannot be read: {error.strerror}") from error


def _similar(folder: Path) -> str:
    """A question that suggests a similar folder for a missing one, if there is any."""
    try:
        names = [path.name for path in folder.parent.iterdir() if path.is_dir()]
    except OSError:
        return ""
    near = difflib.get_close_matches(folder.name, names, n=1)
    return f"; did you mean {folder.with_name(near[0])}?" if near else ""


def _is_mesh(path: Path, folder: Path) -> bool:
    hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
    return path.suffix.lower() in ENDINGS and not hidden and not path.is_dir()


def objects_in(folder: Path, pattern: str = EVERY_FILE) -> dict[str, Path]:
    """The mesh files of `mesh_files` by what its wildcards match: `*/scan/mesh.ply` gives `mug`."""
    paths = [path.relative_to(folder) for path in mesh_files(folder, pattern)]
    named = _unique({path: _matched(path, pattern) for path in paths})
    return {name: folder / path for name, path in named.items()}


def object_names(files: Iterable[Path]) -> dict[str, Path]:
    """Files from anywhere by the names of their objects: the name of the file without ending."""
    return _unique({path: [path.stem] for path in files})


def _matched(path: Path, pattern: str) -> list[str]:
    """The parts of a path that wildcards match, without the ending; the last if there are none."""
    parts = path.with_suffix("").parts
    kinds = PurePosixPath(pattern).with_suffix("").parts
    if "**" in kinds:
        place = kinds.index("**")
        folders = ("*",) * (len(parts) - len(kinds) + 1)
        kinds = kinds[:place] + folders + kinds[place + 1 :]
    pairs = zip(parts, kinds, strict=True)
    return [part for part, kind in pairs if _WILDCARD.search(kind)] or [parts[-1]]


def _unique(parts: Mapping[Path, Sequence[str]]) -> dict[str, Path]:
    """A safe name for each file; those that are the same get an ending, or a hash of their path."""

    def ending(path: Path) -> str:
        return path.suffix[1:].lower()

    def digest(path: Path) -> str:
        return hashlib.sha256(path.as_posix().encode()).hexdigest()[:8]

    safe = {path: re.sub(r"[^A-Za-z0-9._-]", "_", "-".join(words)) for path, words in parts.items()}
    names = {path: text.lstrip(".-") or "object" for path, text in safe.items()}
    for addition in (ending, digest):
        times = Counter(name.lower() for name in names.values())
        names = {
            path: f"{name}-{addition(path)}" if times[name.lower()] > 1 else name
            for path, name in names.items()
        }
    return {name: path for path, name in names.items()}


def write_zip(path: Path, folders: Iterable[Path]) -> None:
    """Pack all files of folders, in this order, with the same times and permissions for all."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for folder in folders:
            for file in sorted(each for each in files_below(folder) if each.is_file()):
                entry = zipfile.ZipInfo(file.relative_to(folder).as_posix(), EARLIEST)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.create_system, entry.external_attr = UNIX, READABLE
                archive.writestr(entry, file.read_bytes())
