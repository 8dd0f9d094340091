"""The JSON schema of the configuration, and the part of it at a path."""

from collections.abc import Sequence
from functools import cache

from egad._util.parameters import Node, resolved
from egad.config import Settings


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
