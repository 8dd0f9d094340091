"""Where files come from, noted for every command of the pipeline."""

import hashlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from egad import __version__
from egad.errors import UserError


@contextmanager
def recorded(
    module: str,
    settings: BaseModel | None,
    reads: Iterable[Path],
    writes: Iterable[Path] = (),
    **arguments: object,
) -> Iterator[None]:
    """Tables written in the block keep where they come from, other files have it beside them.

    Files that the settings name are inputs too, and the user's own code.

    Args:
        module: Name of the stage: its module in `egad.pipeline.stages`.
        settings: Those that it reads.
        reads: Files and folders that it reads.
        writes: Folders that it writes, and files that are no tables.
        arguments: What else decides the result.
    """
    from egad.exchange.sums import sum_of, write_sums
    from egad.pipeline.code_version import code_version
    from egad.tables.origin import Origin, made_by

    inputs = [*reads, *(named_files(settings) if settings else [])]
    origin = Origin(
        program=__version__,
        stage=module,
        code=code_version(f"egad.pipeline.stages.{module}"),
        settings=settings_hash(settings) if settings else None,
        seed=getattr(settings, "seed", None),
        arguments={name: value for name, value in arguments.items() if value is not None},
        inputs=tuple((path, sum_of(path)) for path in inputs if path.exists()),
    )
    with made_by(origin):
        yield
        for path in writes:
            write_sums(path)


def settings_hash(settings: BaseModel) -> str:
    """A fingerprint of settings: 16 hexadecimal digits."""
    return hashlib.sha256(settings.model_dump_json().encode()).hexdigest()[:16]


def named_files(settings: BaseModel) -> list[Path]:
    """The files that settings name: meshes, weights, and the user's own code if it is there."""
    from egad.plugins import source_file

    paths = []
    for key, value in _texts(settings.model_dump(mode="json")):
        if key in ("mesh", "weights") and Path(value).is_file():
            paths.append(Path(value))
        elif key in ("complexity", "difficulty", "detector") and ":" in value:
            with suppress(UserError):
                paths.append(source_file(value, key))
    return paths


def _texts(value: Any, key: str = "") -> Iterator[tuple[str, str]]:  # noqa: ANN401 (JSON)
    """All texts in nested values, with the names that they have."""
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from _texts(each, name)
    elif isinstance(value, list):
        for each in value:
            yield from _texts(each, key)
