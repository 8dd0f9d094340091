"""Recording where files come from, together with what a stage or command writes."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from egad import __version__
from egad.io import checksum
from egad.tables.origin import Origin, made_by


@contextmanager
def recorded(
    stage: str,
    *,
    code: str = "",
    settings: BaseModel | Mapping[str, Any] | None = None,
    arguments: Mapping[str, Any] | None = None,
    inputs: Iterable[Path] = (),
) -> Iterator[None]:
    """Record the origin of whatever is written in the block, by a rule or command.

    Recorded are the fingerprint of its code, the hash and the seed of the settings, the hashes of
    inputs, files and folders, and other arguments that determine the result, except for None.
    """
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
