"""The definitions in modules, read from the source: the code of each, and what it uses."""

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

LOOSE = ""  # the name of statements that define nothing and run whenever the module is imported
SCRIPT = ".py"  # scripts are named by their paths, modules by dotted names
SETTINGS = {"parameters", "sections", "settings", "stages"}  # modules that define settings
_METHODS = {"property", "cached_property", "classmethod", "staticmethod", "cache"}
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class Definition(NamedTuple):
    """A function, class, constant or method."""

    code: str  # its statements in one fixed layout, without comments and docstrings
    uses: frozenset[str]  # dotted names in it, such as `PADS` and `np.pad`
    words: frozenset[str]  # names of attributes in it, and texts: they may name methods and files


class Module(NamedTuple):
    """A module."""

    definitions: Mapping[str, list[Definition]]  # by name, which may be defined twice; or `LOOSE`
    methods: Mapping[str, Mapping[str, Definition]]  # of settings, by class and name
    imports: Mapping[str, set[str]]  # what local names refer to, also those within functions


@cache
def read_module(package: Path, name: str) -> Module:
    """The definitions of a module of the package or a script, or `ModuleNotFoundError`."""
    path = source_of(package, name)
    if path is None:
        raise ModuleNotFoundError(f"{name} is not a module of {package}")
    if name.endswith(SCRIPT):
        return _parsed(path.read_bytes(), package.name, package.name)
    here = name if path.name == "__init__.py" else name.rpartition(".")[0]
    return _parsed(path.read_bytes(), name, here)


@cache
def _parsed(source: bytes, name: str, here: str) -> Module:
    """The definitions in the source of a module of the package `here`."""
    tree = ast.parse(source, filename=name)
    imports: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        _drop_docstring(node)
        for local, target in _imported(node, here):
            imports.setdefault(local, set()).add(target)
    foreign = {local for local, targets in imports.items() if not _ours(targets, name)}
    methods: dict[str, dict[str, Definition]] = {}
    if name.rpartition(".")[2] in SETTINGS:
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                methods[node.name] = {each.name: _definition(each, foreign) for each in _cut(node)}
    definitions: dict[str, list[Definition]] = {}
    for statement in tree.body:
        if not isinstance(statement, ast.Import | ast.ImportFrom) and not _for_types(statement):
            found = _definition(statement, foreign)
            for bound in _bound(statement):
                definitions.setdefault(bound, []).append(found)
    return Module(definitions, methods, imports)


def source_of(package: Path, name: str) -> Path | None:
    """The file of a module or script; None if there is none."""
    if name.endswith(SCRIPT):
        return Path(name) if Path(name).is_file() else None
    return _sources(package).get(name)


@cache
def _sources(package: Path) -> Mapping[str, Path]:
    """The files of all modules of a package, by their dotted names."""
    files = sorted(package.rglob("*.py"), key=lambda path: path.name == "__init__.py")
    paths = ((path, path.relative_to(package.parent).with_suffix("")) for path in files)
    return {".".join(each.parts).removesuffix(".__init__"): path for path, each in paths}


@cache
def offered(package: Path, name: str) -> Mapping[str, str]:
    """Names that the stub of a package re-exports, and the dotted name that each refers to."""
    path = source_of(package, name)
    stub = path.with_suffix(".pyi") if path else None
    if stub is None or not stub.is_file():
        return {}
    return dict(
        pair for node in ast.parse(stub.read_bytes()).body for pair in _imported(node, name)
    )


def _definition(node: ast.stmt, foreign: set[str]) -> Definition:
    uses, words = set(), set()
    waiting: list[ast.AST] = [node]
    while waiting:
        each = waiting.pop()
        attributes = []
        while isinstance(each, ast.Attribute):
            attributes.append(each.attr)
            each = each.value
        if isinstance(each, ast.Name) and not _is_stored(each):
            uses.add(".".join([each.id, *reversed(attributes)]))
            attributes = [] if each.id in foreign else attributes
        elif isinstance(each, ast.Constant) and isinstance(each.value, str):
            words.add(each.value)
        words.update(attributes)
        waiting.extend(ast.iter_child_nodes(each))
    return Definition(ast.unparse(node), frozenset(uses), frozenset(words))


def _bound(node: ast.stmt) -> set[str]:
    """The names that a statement of a module defines."""
    if isinstance(node, (*_FUNCTIONS, ast.ClassDef)):
        return {node.name}
    inside = list(ast.walk(node))
    names = {each.id for each in inside if isinstance(each, ast.Name) and _is_stored(each)}
    names |= {each.name for each in inside if isinstance(each, (*_FUNCTIONS, ast.ClassDef))}
    return names or {LOOSE}


def _is_stored(name: ast.Name) -> bool:
    return isinstance(name.ctx, ast.Store)


def _for_types(node: ast.stmt) -> bool:
    """Whether a statement is only for type checkers."""
    return (
        isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING" and not node.orelse
    )


def _cut(settings: ast.ClassDef) -> Iterator[ast.FunctionDef]:
    """Remove methods and validators from a class of settings; yield the methods.

    A stage gets values that have been validated. Only the type and the default of a field count.
    """
    for node in [each for each in settings.body if isinstance(each, ast.FunctionDef)]:
        settings.body.remove(node)
        if {ast.unparse(each).rpartition(".")[2] for each in node.decorator_list} <= _METHODS:
            yield node
    for call in ast.walk(settings):
        if isinstance(call, ast.Call) and ast.unparse(call.func) == "Field":
            call.keywords = [each for each in call.keywords if "default" in (each.arg or "")]
    settings.body = settings.body or [ast.Pass()]


def _imported(node: ast.AST, here: str) -> Iterator[tuple[str, str]]:
    """The local names that a node imports, and what they refer to."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            top = alias.name.partition(".")[0]
            yield alias.asname or top, alias.name if alias.asname else top
    elif isinstance(node, ast.ImportFrom):
        parts = here.split(".")
        start = parts[: len(parts) + 1 - node.level] if node.level else []
        base = ".".join([*start, *([node.module] if node.module else [])])
        yield from ((alias.asname or alias.name, f"{base}.{alias.name}") for alias in node.names)


def _ours(targets: set[str], module: str) -> bool:
    """Whether something imported comes from the package of a module."""
    return module.partition(".")[0] in {target.partition(".")[0] for target in targets}


def _drop_docstring(node: ast.AST) -> None:
    if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
        node.body = node.body[1:] or [ast.Pass()]
