"""Which compiled code the tests of a file can run."""

import ast
from functools import cache

from egad.workflow.code_version import PACKAGE, used_names

SCRIPTS = PACKAGE.parent / "workflow/scripts"


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
        modules = {module, *(name for name, _ in used_names(script if script.exists() else module))}
    except ModuleNotFoundError:  # the name of something in a module
        return set()
    sources = {name: PACKAGE.parent / f"{name.replace('.', '/')}.py" for name in modules}
    return {
        name
        for name, source in sources.items()
        if source.exists() and b"\n@kernel(" in source.read_bytes()
    }
