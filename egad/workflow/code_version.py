"""A fingerprint of the code behind a script, so that editing the library re-runs its stage.

Snakemake sees a changed rule and a changed script, but not a changed module of the library. The
workflow gives every rule the version of what its script uses as a parameter.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from egad.workflow.definitions import LOOSE, SCRIPT, Definition, offered, read_module, source_of

PACKAGE = Path(__file__).parents[1]
EXCLUDED = ("workflow.job", "provenance.record")  # how scripts run, and the record of it
# The top module counts only for what it re-exports, as it contains the version of the release.
Name = tuple[str, str]  # of a definition: its module, and its name there


@cache
def code_version(module: str | Path, package: Path = PACKAGE) -> str:
    """A fingerprint of a script or module and of everything that it uses of the package.

    Functions, classes and constants count at any depth if their names are used, wherever these come
    from; so do the types and defaults of settings. Other files of a package, such as templates and
    data, count byte for byte if a definition that counts contains their name or that of their
    folder. Everything is read from the source, and nothing is imported. Comments, docstrings and
    layout do not count, nor do descriptions and limits of settings: a stage gets their values.

    Args:
        module: Path of a script, or dotted name of a module of the package.
        package: Folder of the top package.

    Returns:
        16 hexadecimal digits.

    Raises:
        ModuleNotFoundError: There is no such script or module.
    """
    used = _Used(str(module), package)
    digest = hashlib.sha256()
    for name in sorted(used.found):
        codes = (each.code for each in used.found[name])
        digest.update("\n".join([f"{name[0].rpartition('/')[2]}.{name[1]}", *codes, ""]).encode())
    for path in sorted(used.files):
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def used_names(module: str | Path, package: Path = PACKAGE) -> set[Name]:
    """The definitions that count for a module: the module of each, and its name there."""
    return {name for name in _Used(str(module), package).found if name[1]}


class _Used:
    """The definitions and files that count for a module."""

    def __init__(self, module: str, package: Path) -> None:
        self.found: dict[Name, list[Definition]] = {}
        self.files: set[Path] = set()
        self._package = package
        self._modules: set[str] = set()
        self._words: set[str] = set()
        self._methods: dict[Name, tuple[str, Definition]] = {}
        read_module(package, module)
        self._follow(_everything_in(package, module))
        while self._follow_methods() or self._follow_files():
            pass

    def _follow(self, names: Iterable[Name]) -> None:
        """Include definitions, and those that they use."""
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name not in self.found:
                definitions, methods, uses = _about(self._package, name)
                self._take(name, definitions)
                self._methods.update(methods)
                waiting.extend(uses)

    def _take(self, name: Name, definitions: list[Definition]) -> None:
        self.found[name] = definitions
        self._modules.add(name[0])
        for each in definitions:
            self._words.update(each.words)

    def _follow_methods(self) -> bool:
        """Include methods of settings whose names occur; return whether there were more."""
        more = [
            (name, definition)
            for name, (method, definition) in self._methods.items()
            if name not in self.found and (method in self._words or method.startswith("__"))
        ]
        for name, definition in more:
            self._take(name, [definition])
            self._follow(_named_in(self._package, name[0], definition))
        return bool(more)

    def _follow_files(self) -> bool:
        """Include files whose names, or folder names, occur; return whether there were more."""
        more = {
            path
            for module in self._modules
            for path in _other_files(self._package, module)
            if path not in self.files and not self._words.isdisjoint((path.name, path.parent.name))
        }
        self.files |= more
        self._words.update(word for path in more for word in _words(path))
        return bool(more)


class _About(NamedTuple):
    """What is known of a name."""

    definitions: list[Definition]
    methods: Mapping[Name, tuple[str, Definition]]  # of settings: name without the class
    uses: frozenset[Name]  # what it uses, and what runs when the modules around it are imported


@cache
def _about(package: Path, name: Name) -> _About:
    module, local = name
    read = read_module(package, module)
    definitions = read.definitions.get(local, [])
    methods = {
        (module, f"{local}.{method}"): (method, definition)
        for method, definition in read.methods.get(local, {}).items()
    }
    used = {found for each in definitions for found in _named_in(package, module, each)}
    around = {(each, LOOSE) for each in _with_parents(module) if "." in each}
    return _About(definitions, methods, frozenset(used | around))


def _named_in(package: Path, module: str, definition: Definition) -> Iterator[Name]:
    for used in definition.uses:
        yield from _resolved(package, module, tuple(used.split(".")))


@cache
def _resolved(package: Path, module: str, used: tuple[str, ...]) -> frozenset[Name]:
    """The definitions that a dotted name in a module refers to."""
    if module.partition(".")[2] in EXCLUDED or source_of(package, module) is None:
        return frozenset()
    if not used:  # the module itself: anything in it may be used
        return _everything_in(package, module)
    read, (first, *rest) = read_module(package, module), used
    own = first in read.definitions and module != package.name
    found = {(module, first)} if own else set()
    targets = [*read.imports.get(first, ()), *read.imports.get("*", ())]
    if (stands_for := offered(package, module).get(first)) is not None:
        targets.append(stands_for)
    elif source_of(package, f"{module}.{first}"):
        targets.append(f"{module}.{first}")
    for target in targets:
        base, _, name = target.rpartition(".")
        if source_of(package, target):
            found |= _resolved(package, target, tuple(rest))
        elif base != module:
            found |= _resolved(package, base, (first if name == "*" else name, *rest))
    return frozenset(found)


def _everything_in(package: Path, module: str) -> frozenset[Name]:
    return frozenset((module, name) for name in [*read_module(package, module).definitions, LOOSE])


def _with_parents(name: str) -> Iterator[str]:
    """`a.b.c`, `a.b` and `a`: importing a module runs the packages around it; a script has none."""
    while name and not name.endswith(SCRIPT):
        yield name
        name = name.rpartition(".")[0]


@cache
def _other_files(package: Path, module: str) -> list[Path]:
    """Files in the folder of a subpackage, and below it, that are neither code nor stubs."""
    path = source_of(package, module)
    if path is None or path.name != "__init__.py" or module == package.name:
        return []
    return sorted(
        file
        for file in path.parent.rglob("*")
        if file.is_file() and file.suffix not in (".py", ".pyi") and "__pycache__" not in file.parts
    )


@cache
def _words(path: Path) -> frozenset[str]:
    """The words and quoted file names in a text file."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return frozenset()
    return frozenset([*re.findall(r"(?<=[\"'])[\w.-]+(?=[\"'])", text), *re.findall(r"\w+", text)])
