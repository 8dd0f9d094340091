"""User code: functions and classes in the user's own files, named `FILE.py:NAME`."""

import ast
import hashlib
import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeGuard

from egad.errors import RejectedError, UserError

PACKAGE = Path(__file__).parent


@lru_cache
def find(name: str, where: str, kind: str) -> Any:  # noqa: ANN401 (it is the user's)
    """Import `FILE.py:NAME` or `package.module:NAME`; `UserError` names `where` and the kind."""
    module, _, attribute = name.rpartition(":")
    path = _source(module, name, where)
    try:
        found = getattr(_loaded(module, path), attribute, None)
    except Exception as error:
        message = f"{where}: {path} cannot be run: {type(error).__name__}: {error}"
        raise UserError(message) from error
    if not callable(found):
        raise UserError(f"{where}: there is no {kind} {attribute} in {path}")
    return found


def call(what: str, run: Callable[[], Any]) -> Any:  # noqa: ANN401 (it is the user's)
    """What the user's code gives; `RejectedError` says which line of theirs failed, and how."""
    try:
        return run()
    except MemoryError:
        raise  # says nothing about the object
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        theirs = [frame for frame in frames if not Path(frame.filename).is_relative_to(PACKAGE)]
        last = f" in line {theirs[-1].lineno} of {Path(theirs[-1].filename).name}" if theirs else ""
        text = f"{what} failed{last}: {type(error).__name__}: {error}"
        raise RejectedError(text) from error


def named(text: str, arguments: int = 3) -> str:
    """A full name: `FILE.py` is completed by the only thing in it with so many arguments."""
    path = Path(text)
    if path.suffix != ".py":
        return text
    if not path.is_file():
        raise UserError(f"there is no file {text}")
    try:
        body = ast.parse(path.read_bytes()).body
    except SyntaxError as error:
        raise UserError(f"{text}, line {error.lineno}: {error.msg}") from error
    names = [node.name for node in body if _is_called_with(node, arguments)]
    if len(names) != 1:
        choice = f"several: {', '.join(names)}" if names else "none"
        raise UserError(
            f"{text} must have one function of {arguments} arguments, or one class that is called "
            f"with them, but has {choice}; name it: {text}:NAME"
        )
    return f"{text}:{names[0]}"


def _is_called_with(node: ast.stmt, arguments: int) -> TypeGuard[ast.FunctionDef | ast.ClassDef]:
    """Whether a statement defines something public that takes this many arguments."""
    if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
        methods = [each for each in node.body if isinstance(each, ast.FunctionDef)]
        return any(each.name == "__call__" and _count(each) == arguments + 1 for each in methods)
    if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
        return _count(node) == arguments
    return False


def _count(function: ast.FunctionDef) -> int:
    return len(function.args.posonlyargs) + len(function.args.args)


def source_hash(name: str, where: str) -> str:
    """A fingerprint of the file that a name is defined in, which is not run, but its package is."""
    return file_hash(source_file(name, where), where)


def source_file(name: str, where: str) -> Path:
    """The file that a name is defined in, which is not run; raises the errors of `source_hash`."""
    return _source(name.rpartition(":")[0], name, where)


def file_hash(path: str | Path, where: str) -> str:
    """A fingerprint of any file; `UserError` if there is none."""
    if not Path(path).is_file():
        raise UserError(f"{where}: there is no file {path}")
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def _source(module: str, name: str, where: str) -> Path:
    missing = f"{where}: {name}: there is no such file or module"
    try:
        path: Path | None = Path(module)
        if not module.endswith(".py"):  # its package is run
            spec = importlib.util.find_spec(module)
            path = Path(spec.origin) if spec is not None and spec.origin is not None else None
    except Exception as error:
        raise UserError(f"{missing} ({type(error).__name__}: {error})") from error
    if path is None or not path.is_file():
        raise UserError(missing)
    return path


def _loaded(module: str, path: Path) -> ModuleType:
    if not module.endswith(".py"):
        return importlib.import_module(module)
    mark = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:8]
    spec = importlib.util.spec_from_file_location(f"egad_own_{path.stem}_{mark}", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not Python")
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = loaded  # dataclasses look for it
    spec.loader.exec_module(loaded)
    return loaded
