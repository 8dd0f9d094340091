"""HDF5 files: the same bytes every time, never half written, and errors in sentences."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import ArrayLike

from egad._util.files import atomic_output
from egad.errors import UserError

# Compact groups and attributes, which every HDF5 library since 2008 reads.
VERSION = ("v108", "v108")
_KEY = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
_SYSTEM_REASON = re.compile(r"errno = [1-9]\d*, error message = '([^']*)'")
_WRITE_FAILED = re.compile(r"write failed.*?" + _SYSTEM_REASON.pattern, re.DOTALL)


class DamagedError(UserError):
    """A file is not HDF5, truncated or damaged, or lacks something; why, in HDF5's words."""

    def __init__(self, path: Path, reason: str) -> None:
        """Name the file and say what to do about it."""
        super().__init__(f"{path}: truncated or damaged ({reason}); delete it and make it again")
        self.reason = reason


@contextmanager
def writing(path: Path) -> Iterator[h5py.File]:
    """A new file, which gets its name once it is complete, or else is gone, with UserError."""
    try:
        with (
            atomic_output(path, keep=False) as temporary,
            h5py.File(temporary, "w", libver=VERSION) as file,
        ):
            yield file
    except Exception as error:
        reason = _WRITE_FAILED.search(str(error))
        if reason is None:
            raise
        raise UserError(f"{path} cannot be written: {reason[1]}") from error


def sound_keys(path: Path, group: str) -> list[str]:
    """Names in a group of a file; DamagedError unless the whole file can be read."""
    try:
        with h5py.File(path, "r") as file:
            _read_all(file)
            return list(file[group])
    except FileNotFoundError as error:
        raise UserError(f"{path}: there is no such file") from error
    except (OSError, RuntimeError, KeyError) as error:
        if reason := _SYSTEM_REASON.search(str(error)):
            raise UserError(f"{path} cannot be read: {reason[1]}") from error
        text = str(error.args[0] if error.args else error)
        raise DamagedError(path, text.partition("\n")[0]) from error


def _read_all(item: h5py.Group | h5py.Dataset) -> None:
    """Read every attribute and array; HDF5 compares their checksums."""
    dict(item.attrs)
    if isinstance(item, h5py.Group):
        for name in item:  # .values() has None for damaged items
            _read_all(item[name])
        return
    item[()]
    if item.chunks:  # a chunk that is lost reads as zeros
        item.id.read_direct_chunk((0,) * item.ndim)


def check_key(name: str, what: str = "object") -> str:
    """Return a name of letters, digits, `_`, `-` and `.`, for HDF5 and files; else UserError."""
    if _KEY.fullmatch(name):
        return name
    raise UserError(
        f"{what} {name!r} cannot be exported under this name; allowed are the letters a-z and A-Z, "
        "digits, `_`, `-` and `.`, the last two not at the start"
    )


def add_group(parent: h5py.Group, path: str) -> h5py.Group:
    """Add a group level by level: intermediate groups that HDF5 makes itself hold the time."""
    group = parent
    for name in path.split("/"):
        group = group.require_group(name)
    return group


def add_array(group: h5py.Group, name: str, values: ArrayLike) -> None:
    """Add an array, compressed, in one chunk with a checksum; as it is if it is empty."""
    array = np.asarray(values)
    if array.size == 0:
        group.create_dataset(name, data=array)
        return
    group.create_dataset(
        name, data=array, chunks=array.shape, compression="gzip", shuffle=True, fletcher32=True
    )


def copy_group(source: h5py.Group, target: h5py.Group) -> None:
    """Copy a group as if newly made, unlike HDF5's own copy; arrays stay compressed."""
    for name, value in source.attrs.items():
        target.attrs[name] = value
    for name, item in source.items():
        if isinstance(item, h5py.Group):
            copy_group(item, target.create_group(name))
        elif item.chunks is None:
            target.create_dataset(name, data=item[()])
        else:
            copied = target.create_dataset_like(name, item)
            mask, chunk = item.id.read_direct_chunk((0,) * item.ndim)
            copied.id.write_direct_chunk((0,) * item.ndim, chunk, mask)
