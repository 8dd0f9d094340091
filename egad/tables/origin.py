"""What a file was made from and by, recorded at the top level, where the inputs are known.

`parquet.write` and `io.sums.write_sums` put it into what they write, so that no function
between the two has to pass it on. It holds no time, no machine name and no absolute path: the same
configuration gives the same origin.
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ELSEWHERE = "elsewhere:"


@dataclass(frozen=True)
class Origin:
    """What a file was made from and by."""

    program: str  # its version
    stage: str  # name of the rule or command
    code: str  # fingerprint of its code
    settings: str | None = None  # hash of the settings that it reads; none if it reads none
    seed: int | None = None
    arguments: Mapping[str, Any] = field(default_factory=dict)  # that decide the result, too
    inputs: tuple[tuple[Path, str], ...] = ()  # files and folders, and their hashes

    def noted(self, folder: Path) -> dict[str, Any]:
        """As plain values, for a file in a folder; inputs elsewhere only by name."""
        inputs = [[_relative(path, folder), digest] for path, digest in self.inputs]
        return {**self.__dict__, "arguments": dict(self.arguments), "inputs": inputs}


_current: ContextVar[Origin | None] = ContextVar("origin", default=None)


@contextmanager
def made_by(origin: Origin) -> Iterator[None]:
    """Whatever is written in the block has this origin."""
    token = _current.set(origin)
    try:
        yield
    finally:
        _current.reset(token)


def noted(folder: Path) -> dict[str, Any] | None:
    """The origin of what is being written into a folder; None outside of `made_by`."""
    origin = _current.get()
    return None if origin is None else origin.noted(folder)


def _relative(path: Path, folder: Path) -> str:
    here = Path.cwd()
    path, folder = (Path(os.path.normpath(each.absolute())) for each in (path, folder))
    if path.is_relative_to(here) and folder.is_relative_to(here):
        return Path(os.path.relpath(path, folder)).as_posix()
    return f"{ELSEWHERE}{path.name}"
