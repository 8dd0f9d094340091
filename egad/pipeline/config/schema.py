"""The JSON schema of the configuration, and its limits in words."""

from collections.abc import Sequence
from functools import cache
from typing import Any

from egad.pipeline.config import Settings

Node = dict[str, Any]
_KINDS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "null": "nothing",
}


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


def keys_of(node: Node) -> list[str]:
    """The keys that a section can have; none for a table with names of the user's own."""
    return list(node.get("properties", {}))


def allowed(node: Node) -> str:
    """What a value may be, as a phrase: `a whole number, at least 1`."""
    if "anyOf" in node:
        return " or ".join(allowed(option) for option in node["anyOf"])
    choices = [node["const"]] if "const" in node else node.get("enum")
    if choices:
        return " or ".join(map(str, choices))
    if node["type"] == "array":
        return _allowed_list(node)
    if "properties" in node:
        return f"a section with the keys {', '.join(keys_of(node))}"
    if node["type"] == "object":
        return "a table with at least one name"
    if "pattern" in node:
        return "a name of small letters, digits, _ and -"
    return ", ".join([_KINDS[node["type"]], *_limits(node)])


def _child(node: Node, key: str | int) -> Node | None:
    child: Node | None
    if isinstance(key, int):
        items = node.get("prefixItems", [])
        child = items[key] if key < len(items) else node.get("items")
    elif "patternProperties" in node:
        child = next(iter(node["patternProperties"].values()))
    else:
        child = node.get("properties", {}).get(key)
    if child is not None and "$ref" in child:
        child = schema()["$defs"][child["$ref"].rpartition("/")[2]]
    return child


def _allowed_list(node: Node) -> str:
    items = node.get("prefixItems")
    if items:
        return f"a list of {len(items)}, each {allowed(items[0])}"
    return f"a list{' (not empty)' if node.get('minItems') else ''}, each {allowed(node['items'])}"


def _limits(node: Node) -> list[str]:
    low, high = node.get("minimum"), node.get("maximum")
    if low is not None and high is not None:
        return [f"{low:g} to {high:g}"]
    words = {
        "exclusiveMinimum": "above {:g}",
        "minimum": "at least {:g}",
        "exclusiveMaximum": "below {}",
        "maximum": "at most {:g}",
    }
    return [words[key].format(node[key]) for key in words if key in node]
