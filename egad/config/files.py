"""Configuration files: read, and merged as Snakemake merges them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from egad.config.settings import Settings
from egad.errors import UserError

BUILT_IN = ("grippers", "cameras", "detectors")


def read_values(path: Path) -> dict[str, Any]:
    """The values in a configuration file, not checked; none if it is empty.

    Raises:
        UserError: The file is not YAML.
    """
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: not a YAML file: {error}") from error


def defaults() -> dict[str, Any]:
    """All settings with their defaults, except those without a value."""
    values: dict[str, Any] = json.loads(Settings().model_dump_json(exclude_none=True))
    return values


def merged(old: Any, new: Any) -> Any:  # noqa: ANN401 (any values of YAML)
    """Values merged into others as Snakemake does: tables key by key, anything else replaced."""
    if not isinstance(new, Mapping):
        return new
    known = old if isinstance(old, Mapping) else {}
    return {**known, **{key: merged(known.get(key), value) for key, value in new.items()}}


def with_built_in(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values with the grippers, cameras and detectors that are built in.

    Those of the user come beside them; keys of an entry of the same name replace its keys.
    """
    given = [name for name in BUILT_IN if isinstance(values.get(name), Mapping)]
    known = defaults() if given else {}
    return {**values, **{name: merged(known[name], values[name]) for name in given}}
