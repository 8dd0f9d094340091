"""The list of all settings in `config/README.md`, and the manual of the results.

`python docs/manual/manual.py` writes both, `--check` says whether they are up to date.
"""

import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import results_page

from egad._util.files import write_text
from egad._util.markdown import table
from egad._util.parameters import Node, allowed, keys_of
from egad_workflow.check import node_at
from egad_workflow.config_files import defaults

PAGE = Path("config/README.md")
SIGNS = {"at least": "≥", "above": ">", "at most": "≤", "below": "<", ", each": ":"}
BETWEEN = re.compile(r"(?<=<!-- settings -->\n).*(?=<!-- end -->)", re.DOTALL)


def manual() -> str:
    """All settings with their defaults, as Markdown."""
    known = defaults()
    single = [name for name in keys_of(node_at(()) or {}) if not _is_section(name)]
    general = [name for name in single if not _is_table(name)]
    shown: set[str] = set()
    parts = ["\n", table(["setting", "default", "meaning", "allowed"], _rows((), general, known))]
    before = ""
    for name in keys_of(node_at(()) or {}):
        path: tuple[str, ...] = (name, "any") if _is_table(name) else (name,)
        if name not in general:
            keys = _keys(path, known.get(name, {}))
            told = "The keys are those of the section above.\n" if keys == before else keys
            before = keys
            parts += [
                f"\n### `{name}`\n\n",
                f"{_about(name)}\n\n",
                told,
                *_nested(path, known.get(name, {}), shown),
            ]
    return "".join(parts) + "\n"


def _nested(path: tuple[str, ...], known: Mapping[str, Any], shown: set[str]) -> Iterator[str]:
    """The sections within a section, of a kind that was not shown yet."""
    for key in keys_of(node_at(path) or {}):
        inner = (*path, key)
        node = node_at(inner) or {}
        if "properties" in node and node["title"] not in shown:
            shown.add(node["title"])
            title = ".".join("NAME" if part == "any" else part for part in inner)
            yield f"\n### `{title}`\n\n{_meaning(node)}\n\n"
            yield _keys(inner, known.get(key, {}))
            yield from _nested(inner, known.get(key, {}), shown)


def _meaning(node: Node) -> str:
    return " ".join(str(node.get("description", "")).split())


def _about(name: str) -> str:
    """What a section is about, or the entries that a table has."""
    if _is_table(name):
        return f"Built in: {', '.join(f'`{each}`' for each in defaults().get(name, {}))}."
    about = str((node_at((name,)) or {})["description"])
    return about if about.endswith(".") else f"{about[0].upper()}{about[1:]}."


def _keys(path: tuple[str, ...], known: Mapping[str, Any]) -> str:
    keys = keys_of(node_at(path) or {})
    if path[-1] == "any":  # of an entry; it has no defaults of its own
        return table(["key", "meaning", "allowed"], [_row(path, key)[:3] for key in keys])
    return table(["key", "default", "meaning", "allowed"], _rows(path, keys, known))


def _rows(
    path: tuple[str, ...], keys: list[str], known: Mapping[str, Any]
) -> Iterator[tuple[str, ...]]:
    fields: Node = (node_at(path) or {})["properties"]
    for key in keys:
        name, meaning, may_be = _row(path, key)
        value = known.get(key, fields[key].get("default"))
        inside = isinstance(value, dict)  # has a table of its own
        shown = "" if value is None or inside else f"`{json.dumps(value)}`"
        yield name, shown.replace('"', ""), meaning, may_be


def _row(path: tuple[str, ...], key: str) -> tuple[str, str, str]:
    node: Node = node_at((*path, key)) or {}
    field: Node = (node_at(path) or {})["properties"][key]
    return f"`{key}`", _meaning(field) or _meaning(node), _abbreviated(allowed(node))


def _abbreviated(phrase: str) -> str:
    """What is allowed, with fewer words than in messages."""
    phrase = re.sub(r" of lowercase.* and -| \(not empty\)| with the keys .*", "", phrase)
    phrase = re.sub(r"\ba (?=whole|number|text|name|list)", "", phrase)
    for words, sign in SIGNS.items():
        phrase = phrase.replace(words, sign)
    return phrase


def _is_table(name: str) -> bool:
    return "patternProperties" in (node_at((name,)) or {})


def _is_section(name: str) -> bool:
    return "properties" in (node_at((name,)) or {})


def main() -> None:
    """Write both pages, or with `--check` say which are out of date."""
    text = PAGE.read_text(encoding="utf-8")
    pages = {PAGE: BETWEEN.sub(lambda _: manual(), text), results_page.PAGE: results_page.page()}
    if "--check" not in sys.argv:
        for path, page in pages.items():
            write_text(path, page)
    elif old := [str(path) for path, page in pages.items() if path.read_text("utf-8") != page]:
        sys.exit(f"{', '.join(old)}: out of date; run python docs/manual/manual.py")


if __name__ == "__main__":
    main()
