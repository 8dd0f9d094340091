"""A fingerprint of the code behind a script, so that editing the library re-runs its stage.

Snakemake sees a changed rule and a changed script, but not a changed module of the library. The
workflow gives every rule the version of what its script imports as a parameter.
"""

import ast
import hashlib
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
PACKAGES = (HERE.parent / "egad", HERE)
# how scripts run, and how their provenance is recorded
EXCLUDED = {"egad_workflow.job"}
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def code_version(module: str | Path, packages: tuple[Path, ...] = PACKAGES) -> str:
    """A fingerprint, 16 hexadecimal digits, of a script or module and all that it imports.

    Modules of `packages` count at any depth, also those imported in functions; other files of a
    package byte for byte, if a text in a module that counts is their name or that of their folder.
    Nothing is imported. Comments, docstrings and layout do not count, nor do descriptions and
    limits of settings: a stage gets their values. ModuleNotFoundError without such a module.
    """
    digest = hashlib.sha256()
    modules = imported_modules(str(module), packages)
    for name, each in sorted(modules.items()):
        stem = name.rpartition("/")[2].partition("@")[0]  # `@COMMIT` if from a repository
        digest.update(f"{stem}\n{each.code}\n".encode())
    for path in sorted(_named_files(modules, packages)):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


class Module(NamedTuple):
    """A module or script."""

    code: str  # in one fixed layout, without comments and docstrings
    imports: frozenset[tuple[str, str]]  # modules, and the names imported from them or nothing
    texts: frozenset[str]  # some may name files


def imported_modules(module: str, packages: tuple[Path, ...] = PACKAGES) -> Mapping[str, Module]:
    """A module or script and all modules that it imports, by name; or `ModuleNotFoundError`."""
    found: dict[str, Module] = {}
    waiting = {module}
    while waiting:
        name = waiting.pop()
        found[name] = read_module(name, packages)
        used = (each for pair in found[name].imports for each in _modules_of(*pair, packages))
        waiting |= set(used) - found.keys() - EXCLUDED
    return found


def read_module(name: str, packages: tuple[Path, ...] = PACKAGES) -> Module:
    """A module of the packages or a script, or `ModuleNotFoundError`."""
    path = Path(name) if _is_script(name) else _sources(packages).get(name)
    if path is None or not path.is_file():
        raise ModuleNotFoundError(f"{name} is not a module of {', '.join(map(str, packages))}")
    return _parsed(path.read_bytes(), name if path.name == "__init__.py" else _parent(name))


@cache
def _parsed(source: bytes, here: str) -> Module:
    """What is in the source of a module of the package `here`."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED):  # a text below a setting says what it is
            node.body = [each for each in node.body if not _is_text(each)] or [ast.Pass()]
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "Field":
            node.keywords = [each for each in node.keywords if "default" in (each.arg or "")]
    tree.body = [
        node
        for node in tree.body
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    ]
    nodes = list(ast.walk(tree))
    texts = (each.value for each in nodes if isinstance(each, ast.Constant))
    return Module(
        ast.unparse(tree),
        frozenset(pair for node in nodes for pair in _imports(node, here)),
        frozenset(text for text in texts if isinstance(text, str)),
    )


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(getattr(node.value, "value", None), str)


def _imports(node: ast.AST, here: str) -> Iterator[tuple[str, str]]:
    if isinstance(node, ast.Import):
        yield from ((alias.name, "") for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        parts = here.split(".")
        start = parts[: len(parts) + 1 - node.level] if node.level else []
        base = ".".join([*start, *([node.module] if node.module else [])])
        yield from ((base, alias.name) for alias in node.names)


def _modules_of(base: str, name: str, packages: tuple[Path, ...]) -> Iterator[str]:
    """The modules that run, or are offered, when a name is imported from a module or package."""
    offered = _offered(base, packages)
    if f"{base}.{name}" in _sources(packages):
        yield from _modules_of(f"{base}.{name}", "", packages)
    elif name in offered:
        yield from _modules_of(*offered[name], packages)
    elif "." in base and base in _sources(packages):  # the top module has the version of a release
        yield from (base, *(parent for parent in _parents(base) if "." in parent))
    if not name:  # the package itself: all that it offers may be used
        for target in offered.values():
            yield from _modules_of(*target, packages)


@cache
def _offered(package: str, packages: tuple[Path, ...]) -> Mapping[str, tuple[str, str]]:
    """Names that the stub of a package re-exports: the module of each, and its name there."""
    path = _sources(packages).get(package)
    stub = path.with_suffix(".pyi") if path else None
    if stub is None or not stub.is_file():
        return {}
    nodes = ast.parse(stub.read_bytes()).body
    return {pair[1]: pair for node in nodes for pair in _imports(node, package)}


@cache
def _sources(packages: tuple[Path, ...]) -> Mapping[str, Path]:
    """The files of all modules of some packages, by their dotted names."""
    paths = {}
    for package in packages:
        for path in sorted(package.rglob("*.py")):
            parts = path.relative_to(package.parent).with_suffix("").parts
            paths[".".join(parts).removesuffix(".__init__")] = path
    return paths


def _is_script(name: str) -> bool:
    """Whether it is the path of a script, as modules have dotted names."""
    return "/" in name or name.endswith(".py")


def _parent(name: str) -> str:
    return "" if _is_script(name) else name.rpartition(".")[0]


def _parents(name: str) -> Iterator[str]:
    while name := _parent(name):
        yield name


def _named_files(modules: Mapping[str, Module], packages: tuple[Path, ...]) -> set[Path]:
    """Other files of packages that count, as modules or files that count name them."""
    known = {path for name in modules for path in _other_files(name, packages)}
    texts = {text for module in modules.values() for text in module.texts}
    found: set[Path] = set()
    while more := {path for path in known - found if texts & {path.name, path.parent.name}}:
        found |= more
        texts |= {text for path in more for text in _quoted(path)}
    return found


@cache
def _other_files(module: str, packages: tuple[Path, ...]) -> list[Path]:
    """Files in the folder of a subpackage, and below it, that are neither code nor stubs."""
    path = _sources(packages).get(module)
    if path is None or path.name != "__init__.py" or "." not in module:
        return []
    return [
        file
        for file in path.parent.rglob("*")
        if file.is_file() and file.suffix not in (".py", ".pyi") and "__pycache__" not in file.parts
    ]


@cache
def _quoted(path: Path) -> frozenset[str]:
    """The quoted names in a text file, as of the files that a template includes."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return frozenset()
    return frozenset(re.findall(r"(?<=[\"'])[\w.-]+(?=[\"'])", text))
