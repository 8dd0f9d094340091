"""Checking a configuration: every problem at once, in sentences."""

import copy
import difflib
import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from pydantic import ValidationError

from egad._util.parameters import Node, keys_of, resolved, wanted
from egad.errors import UserError
from egad.sim import check_engine
from egad_workflow.config_files import with_built_in
from egad_workflow.references import wrong_references
from egad_workflow.settings import Settings

Problem = Mapping[str, Any]  # an error of pydantic: its type, loc, input and msg
Path = tuple[str | int, ...]
# These replace entries with a mistake, so that references to them are not reported as well.
_SOUND_ENTRY: dict[str, dict[str, Any]] = {
    "datasets": {"source": "meshes", "folder": ".", "units": "m"},
    "grippers": {"opening": 0.05},
    "cameras": {"focal": [400.0, 400.0], "distance": [0.6, 0.6], "tilt": [0.0, 0.0]},
    "detectors": {"detector": "random"},
}


def check(config: Mapping[str, Any]) -> Settings:
    """Turn a configuration into settings; those that it does not name keep their defaults.

    Its grippers, cameras and detectors are added to the built-in ones. UserError has a line for
    every problem: where it is, what is there, what is allowed, and the nearest valid key.
    """
    if not isinstance(config, Mapping):
        raise UserError(f"a configuration is a table of sections, not {_shown(config)}")
    plain = with_built_in(json.loads(json.dumps(config, default=str)))
    problems: dict[str, None] = {}
    settings, errors = _validated(plain)
    # Rules between settings are checked only where each is valid by itself, hence the loop.
    while errors:
        before = copy.deepcopy(plain)
        problems |= dict.fromkeys(line for error in errors for line in _sentences(error))
        for error in errors:
            _mend(plain, error)
        settings, errors = _validated(plain) if plain != before else (None, [])
    if settings:
        problems |= dict.fromkeys(wrong_references(settings))
    if problems or not settings:
        raise UserError("\n".join(problems))
    return settings


def check_engines(settings: Settings) -> Settings:
    """The settings; `UserError` if a physics engine that they name is not installed."""
    for section in (settings.trials, settings.clutter, settings.scenes, settings.simulated_label):
        check_engine(section.engine)
    for engine in settings.failures.engines if settings.targets.failures else ():
        check_engine(engine)
    return settings


def _validated(config: dict[str, Any]) -> tuple[Settings | None, list[Problem]]:
    """The settings, or what is wrong with them."""
    try:
        # JSON, because its lists become tuples; strict, because a number in quotes is a mistake
        return Settings.model_validate_json(json.dumps(config), strict=True), []
    except ValidationError as error:
        return None, list(error.errors(include_url=False))


def _sentences(error: Problem) -> list[str]:
    """The lines that describe one error of pydantic."""
    path, value = error["loc"], error["input"]
    where = _dotted(path)
    node = node_at(path)
    if error["type"] == "extra_forbidden":
        return [_unknown_key(path)]
    if error["type"] == "value_error":
        text = str(error["ctx"]["error"])
        return [f"{where}: {line}" if where else line for line in text.split("\n")]
    if path[-1] == "[key]":
        name = "a name of lowercase letters, digits, _ and -"
        return [f"{_dotted(path[:-1])}: {_shown(value)} cannot be a name; allowed: {name}"]
    if node is None:
        return [f"{where}: {_shown(value)}: {error['msg']}"]
    if error["type"] == "missing":
        return [f"{where}: is missing; needed: {wanted(node)}"]
    return [f"{where}: {_shown(value)} is not allowed{_hint(value, node)}; allowed: {wanted(node)}"]


def _unknown_key(path: Path) -> str:
    """The sentence for a key; the most similar one is named, if possible of the same section."""
    section = node_at(path[:-1]) or {}
    keys = [*_all_keys(section, path[:-1]), *_all_keys(schema(), ())]
    known = {str(key[-1]): key for key in reversed(keys)}
    nearest = difflib.get_close_matches(str(path[-1]).lower(), known, n=1)
    names = ", ".join(keys_of(section))
    guess = f"did you mean {_dotted(known[nearest[0]])}?" if nearest else f"known: {names}"
    return f"{_dotted(path)}: unknown key; {guess}"


def _all_keys(node: Node, path: Path) -> list[Path]:
    """Every key of the sections below; tables of names have none."""
    found: list[Path] = []
    for key in keys_of(node):
        child = node_at((*path, key)) or {}
        found += [*_all_keys(child, (*path, key)), (*path, key)]
    return found


def _hint(value: object, node: Node) -> str:
    """Why a value that looks right is not."""
    wants_number = node.get("type") in ("integer", "number")
    if isinstance(value, str) and wants_number:
        try:
            number = float(value)
        except ValueError:
            return ""
        written = f"{number:.1e}" if "e" in value.lower() else value.strip()
        return f": that is text; in a file, write {written} without quotes"
    if isinstance(value, float) and node.get("type") == "integer" and value.is_integer():
        return f": write {value:.0f}"
    return ""


def _shown(value: object) -> str:
    """A value as YAML would show it, cut if it is long."""
    text = "nothing" if value is None else json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _dotted(path: Sequence[str | int]) -> str:
    return ".".join(map(str, path))


def _mend(config: dict[str, Any], error: Problem) -> None:
    """Replace what is wrong by something valid, to find other problems."""
    *path, last = error["loc"] or (None,)
    if path and path[0] in _SOUND_ENTRY:
        kind, name = path[0], str(path[1] if path[1:] else last)
        table = config.get(kind, {})
        if last == "[key]":
            del table[name]
        elif name in table:
            table[name] = _SOUND_ENTRY[kind]
        if not table:
            config.pop(kind, None)  # so that the default table takes its place
        return
    section: Any = config
    for key in path:
        if not isinstance(section[key], dict):
            last = key
            break
        section = section[key]
    section.pop(last, None)


@cache
def schema() -> Node:
    """The JSON schema of the whole configuration (draft 2020-12)."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema"
    } | Settings.model_json_schema()


def node_at(path: Sequence[str | int]) -> Node | None:
    """The part of the schema that describes the value at a path; None if there is no such value."""
    node: Node | None = schema()
    for key in path:
        node = None if node is None else _child(node, key)
    return node


def _child(node: Node, key: str | int) -> Node | None:
    child: Node | None
    if isinstance(key, int):
        items = node.get("prefixItems", [])
        child = items[key] if key < len(items) else node.get("items")
    elif "patternProperties" in node:
        child = next(iter(node["patternProperties"].values()))
    else:
        child = node.get("properties", {}).get(key)
    return None if child is None else resolved(child, schema())
