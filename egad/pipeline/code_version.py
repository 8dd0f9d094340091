"""A fingerprint of the code behind a stage, so that editing the library re-runs its stages.

Snakemake sees a changed rule but not a changed module. The workflow gives every rule the version of
its stage module as a parameter.
"""

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# Values of settings reach a stage as parameters of its rule; their definitions decide nothing else.
# The top module, also left out, holds the version of the release and where kernels are kept.
EXCLUDED = {"config", "parameters"}
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def code_version(module: str, package: Path = PACKAGE) -> str:
    """A fingerprint of a module and of all modules of the package that it imports, at any depth.

    Imports are read from the source, those within functions too, and nothing is imported.
    Comments, docstrings and layout do not count. Other files that lie in an imported subpackage,
    such as templates, count byte for byte.

    Args:
        module: Dotted name, e.g. `"egad.pipeline.stages.evolve"`.
        package: Folder of the top package.

    Returns:
        16 hexadecimal digits.

    Raises:
        ModuleNotFoundError: There is no such module in the package.
    """
    digest = hashlib.sha256()
    for name in sorted(imported(module, package)):
        digest.update(f"{name}\n{_read(package, name)[0]}\n".encode())
        for path in _other_files(package, name):
            digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def imported(module: str, package: Path = PACKAGE) -> set[str]:
    """The module itself and all modules of the package that it imports, at any depth."""
    found: set[str] = set()
    waiting = list(_with_parents(module))
    while waiting:
        name = waiting.pop()
        if name not in found | {package.name} and EXCLUDED.isdisjoint(name.split(".")):
            found.add(name)
            waiting.extend(_read(package, name)[1])
    return found


@cache
def _read(package: Path, module: str) -> tuple[str, frozenset[str]]:
    """The code of a module in one fixed layout, and the modules of the package it imports."""
    path = _source(package, module)
    if path is None:
        raise ModuleNotFoundError(f"{module} is not a module of {package}")
    tree = ast.parse(path.read_bytes(), filename=str(path))
    here = module if path.name == "__init__.py" else module.rpartition(".")[0]
    found = {
        name
        for node in ast.walk(tree)
        for target in _targets(node, here)
        for name in _with_parents(_resolved(package, target))
        if _source(package, name) is not None
    }
    _drop_docstrings(tree)
    return ast.unparse(tree), frozenset(found)


def _targets(node: ast.AST, here: str) -> Iterator[str]:
    """Dotted names that a node imports: of modules, or of things within modules."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        parts = here.split(".")
        start = parts[: len(parts) + 1 - node.level] if node.level else []
        base = ".".join([*start, *([node.module] if node.module else [])])
        yield from (f"{base}.{alias.name}" for alias in node.names)


def _resolved(package: Path, target: str) -> str:
    """The module that a name really comes from, where a package offers it in `__init__.pyi`."""
    base, _, name = target.rpartition(".")
    return _offered(package, base).get(name, target)


@cache
def _offered(package: Path, module: str) -> dict[str, str]:
    """Names that the stub of a package re-exports, and the module that each comes from."""
    path = _source(package, module)
    stub = path.with_suffix(".pyi") if path else None
    if stub is None or not stub.is_file():
        return {}
    nodes = [n for n in ast.parse(stub.read_bytes()).body if isinstance(n, ast.ImportFrom)]
    return {alias.name: f"{module}.{node.module}" for node in nodes for alias in node.names}


def _with_parents(name: str) -> Iterator[str]:
    """`a.b.c`, `a.b` and `a`: importing a module runs the packages around it."""
    while name:
        yield name
        name = name.rpartition(".")[0]


def _source(package: Path, module: str) -> Path | None:
    """The file of a module; None if the name is no module of the package."""
    top, *rest = module.split(".")
    if top != package.name:
        return None
    path = package.joinpath(*rest)
    candidates = (path / "__init__.py", path.with_suffix(".py"))
    return next((file for file in candidates if file.is_file()), None)


def _other_files(package: Path, module: str) -> list[Path]:
    """Files in the folder of a subpackage, and below it, that are neither code nor stubs."""
    path = _source(package, module)
    if path is None or path.name != "__init__.py":
        return []
    return sorted(
        file
        for file in path.parent.rglob("*")
        if file.is_file() and file.suffix not in (".py", ".pyi") and "__pycache__" not in file.parts
    )


def _drop_docstrings(tree: ast.Module) -> None:
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:]
