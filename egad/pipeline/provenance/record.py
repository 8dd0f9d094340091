"""Where files come from, noted for every stage by what its parameters declare."""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from egad import __version__
from egad.errors import UserError
from egad.exchange import checksum, write_sums
from egad.pipeline.code_version import code_version
from egad.pipeline.parameters import Declared, Input, Renamed, ShardOf, declared
from egad.plugins import source_file
from egad.tables.origin import Origin, made_by

TABLE = ".parquet"
T = TypeVar("T")


def run_recorded(function: Callable[..., T], **arguments: Any) -> T:  # noqa: ANN401 (of a stage)
    """Run a stage: its tables keep where they come from, other files have it beside them.

    Files that the settings name are inputs too, and the user's own code.

    Args:
        function: Its parameters say what it reads and writes (`egad.pipeline.parameters`).
        arguments: Their values by name.
    """
    parameters = declared(function)
    given = {each.name: arguments.get(each.name, each.default) for each in parameters}
    with made_by(origin_of_run(function, given)):
        result = function(**arguments)
        for path in _other_files(parameters, given):
            write_sums(path)
    return result


def origin_of_run(function: Callable[..., Any], given: Mapping[str, Any]) -> Origin:
    """What is noted of a run of a stage.

    Args:
        function: The stage.
        given: The value of each parameter.
    """
    parameters = declared(function)
    settings = next((given[each.name] for each in parameters if each.is_settings), None)
    inputs = [path for each in parameters for path in _inputs(each, given)]
    inputs += named_files(settings) if settings else []
    noted = {
        name: value
        for each in parameters
        for name, value in _arguments(each, given[each.name])
        if value is not None
    }
    return Origin(
        program=__version__,
        stage=function.__module__.rpartition(".")[2],
        code=code_version(function.__module__),
        settings=settings_hash(settings) if settings else None,
        seed=getattr(settings, "seed", None),
        arguments=noted,
        inputs=tuple((path, checksum(path)) for path in inputs if path.exists()),
    )


def settings_hash(settings: BaseModel) -> str:
    """A fingerprint of settings: 16 hexadecimal digits."""
    return hashlib.sha256(settings.model_dump_json().encode()).hexdigest()[:16]


def named_files(settings: BaseModel) -> list[Path]:
    """The files that settings name, if they are there: of hands, meshes, weights, own code."""
    paths: list[Path] = []
    for key, value in _texts(settings.model_dump(mode="json")):
        if key == "file" and Path(value).is_file():
            from egad.grippers import description_files  # noqa: PLC0415 (loads an engine)

            paths += description_files(Path(value))
        elif key in ("mesh", "weights", "command") and Path(value).is_file():
            paths.append(Path(value))
        elif key in ("complexity", "difficulty", "detector") and ":" in value:
            with suppress(UserError):
                paths.append(source_file(value, key))
    return paths


def _inputs(parameter: Declared, given: Mapping[str, Any]) -> list[Path]:
    """The files and folders that a parameter names as inputs."""
    mark, value = parameter.mark(Input), given[parameter.name]
    if mark is None or value is None:
        return []
    if mark.files:
        return list(mark.files(given))
    if isinstance(value, Mapping):
        return list(value.values())
    return [value] if isinstance(value, Path) else list(value)


def _arguments(parameter: Declared, value: Any) -> Iterator[tuple[str, Any]]:  # noqa: ANN401
    """What is noted of a parameter besides hashes."""
    source, renamed = parameter.mark(Input), parameter.mark(Renamed)
    if source is not None:
        if source.names:
            yield source.names, list(value)
    elif parameter.mark(ShardOf):
        yield from zip(("shard", "shards"), value, strict=True)
    elif not (parameter.outputs or parameter.is_settings or parameter.is_not_noted):
        yield (renamed.name if renamed else parameter.name), value


def _other_files(parameters: list[Declared], given: Mapping[str, Any]) -> Iterator[Path]:
    """Files and folders that were written and are no tables."""
    for each in parameters:
        path = given[each.name]
        if not each.outputs or path is None or path.suffix == TABLE:
            continue
        names = [name for output in each.outputs for name in output.files]
        yield from (path / name for name in names) if names else [path]


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
