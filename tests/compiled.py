"""Which modules have compiled code, and which of it the tests of a file can run."""

import ast
from functools import cache

from egad_workflow.code_version import PACKAGES, imported_modules

PACKAGE = PACKAGES[0]
SCRIPTS = PACKAGE.parent / "workflow/scripts"
TESTS = PACKAGE.parent / "tests"


@cache
def modules_with_kernels():
    """All modules of ours with compiled code."""
    return {
        ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        for path in PACKAGE.rglob("*.py")
        if b"\n@kernel(" in path.read_bytes()
    }


def checks_kernels(path):
    """Whether the tests of a file are of compiled code: it reaches some of its own package."""
    package = path.relative_to(TESTS).parts[0]
    return any(name.split(".")[1] == package for name in reached_kernels(path))


def reached_kernels(path):
    """The modules with compiled code that a Python file imports, or that these import."""
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found.update(*(reached(alias.name) for alias in node.names))
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            found.update(*(reached(name) for name in names))
    return found


@cache
def reached(module):
    """The same of a name, if it is a module or a script of ours."""
    script = SCRIPTS / f"{module.partition('.')[0]}.py"
    if module.partition(".")[0] != "egad" and not script.exists():
        return set()
    try:
        modules = set(imported_modules(str(script) if script.exists() else module))
    except ModuleNotFoundError:  # the name of something in a module
        return set()
    return modules & modules_with_kernels()
