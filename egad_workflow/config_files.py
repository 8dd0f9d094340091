"""Configuration files: read, and merged as Snakemake merges them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from egad.errors import UserError
from egad.grippers import PACKAGED, packaged_settings
from egad_workflow.settings import Settings

BUILT_IN = ("grippers", "cameras", "detectors")
DESCRIBED = {"file", "opening"}  # an entry with one of these is a gripper of its own
# Settings that name entries of tables: section, key and table
NAMES = (
    ("targets", "datasets", "datasets"),
    ("targets", "grippers", "grippers"),
    ("targets", "detectors", "detectors"),
    ("targets", "clutter", "detectors"),
    ("targets", "failures", "detectors"),
    ("render", "camera", "cameras"),
    ("graspability", "gripper", "grippers"),
    ("select_eval", "gripper", "grippers"),
    ("release", "dataset", "datasets"),
    ("release", "gripper", "grippers"),
)


def read_values(path: Path) -> dict[str, Any]:
    """The values in a configuration file, not checked; none if it is empty; or `UserError`."""
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
    """Values with built-in grippers, cameras and detectors; keys of an entry replace its keys."""
    packaged = {name: packaged_settings(name) for name in _packaged(values)}
    if packaged:
        own = values.get("grippers")
        values = {**values, "grippers": merged(packaged, own if isinstance(own, Mapping) else {})}
    given = [name for name in BUILT_IN if isinstance(values.get(name), Mapping)]
    known = defaults() if given else {}
    return {**values, **{name: merged(known[name], values[name]) for name in given}}


def _packaged(values: Mapping[str, Any]) -> list[str]:
    """The hands of other packages that are used without a file or opening being given."""
    used: list[Any] = []
    for section, key in (name[:2] for name in NAMES if name[2] == "grippers"):
        chosen = values.get(section)
        names = chosen.get(key) if isinstance(chosen, Mapping) else None
        used += names if isinstance(names, list) else [names]
    given = values.get("grippers")
    entries = dict(given) if isinstance(given, Mapping) else {}
    wanted = {name: entries.get(name) or {} for name in PACKAGED if name in used or name in entries}
    # an entry that is not a mapping is refused later
    return [
        name
        for name, entry in wanted.items()
        if isinstance(entry, Mapping) and not DESCRIBED & set(entry)
    ]
