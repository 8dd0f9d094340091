"""The origin of a file as a tree of text, back to the seed."""

import os
from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from egad.io import checksum
from egad_workflow.provenance import Noted, is_near, origin_of


class FileNode(NamedTuple):
    """A file, its recorded origin, and what is wrong with it, if anything."""

    path: Path
    noted: Noted | None
    problem: str = ""


Look = Callable[[Path, str], FileNode]


def tree(path: Path) -> Iterator[str]:
    """Lines of text: the file, and below it what it was made from; those made alike are one."""
    root = [FileNode(path, origin_of(path))]
    folders = (Path.cwd(), path if path.is_dir() else path.parent)
    yield _line(root)
    look = partial(_node, folders=folders, digest_of=cache(checksum))
    yield from _below(root, "", set(), cache(look))


def _below(nodes: list[FileNode], indent: str, told: set[Path], look: Look) -> Iterator[str]:
    groups = [list(alike) for _, alike in groupby(_inputs(nodes, look), _likeness)]
    for number, group in enumerate(groups, 1):
        last = number == len(groups)
        known = group[0].path in told and bool(_inputs(group, look))
        told.update(node.path for node in group)
        yield f"{indent}{'└─' if last else '├─'} {_line(group)}{', as above' if known else ''}"
        if not known:
            yield from _below(group, indent + ("   " if last else "│  "), told, look)


def _inputs(nodes: list[FileNode], look: Look) -> list[FileNode]:
    """What files were made from, each once."""
    noted = [node.noted for node in nodes if node.noted]
    sources = dict.fromkeys(source for each in noted for source in each.sources())
    return [look(path, digest) for path, digest in sources]


def _node(
    path: Path, digest: str, folders: tuple[Path, ...], digest_of: Callable[[Path], str]
) -> FileNode:
    was = f"its sha256 was {digest[:16]}..."
    if not os.path.exists(path):  # noqa: PTH110 (that of `Path` raises for what can be none)
        return FileNode(path, None, f"missing; {was}")
    if not is_near(path, folders):
        return FileNode(path, None, f"not checked: outside the working directory; {was}")
    if digest_of(path) != digest:
        return FileNode(path, None, f"ALTERED since; {was}")
    return FileNode(path, origin_of(path))


def _likeness(node: FileNode) -> tuple[object, ...]:
    """A key that is equal for files that were made alike."""
    kind = (node.path.parent, node.path.stem.rstrip("0123456789"), node.path.suffix)
    if node.noted is None:
        return (node.path.parent, node.path.suffix, node.problem.partition(";")[0])
    return (*kind, *(getattr(node.noted, name) for name in ("stage", "code", "settings", "seed")))


def _line(group: list[FileNode]) -> str:
    """A line for files that were made alike, without characters that would move the cursor."""
    node = group[0]
    more = f" and {len(group) - 1} more" if len(group) > 1 else ""
    made = ", ".join(_words(node.noted)) if node.noted else "no provenance recorded"
    line = f"{node.path}{more}: {node.problem or made}"
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def _words(noted: Noted) -> Iterator[str]:
    arguments = [f"{name} {_plain(value)}" for name, value in noted.arguments.items()]
    yield f"{noted.stage} ({', '.join(arguments)})" if arguments else noted.stage
    if noted.seed is not None:
        yield f"seed {noted.seed}"
    if noted.settings:
        yield f"settings {noted.settings}"
    if noted.code:
        yield f"code {noted.code}"
    yield f"egad {noted.program}"


def _plain(value: object) -> str:
    return " ".join(map(str, value)) if isinstance(value, list) else str(value)
