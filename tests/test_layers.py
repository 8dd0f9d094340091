"""How packages import each other: downwards in `LAYERS`, and by what a package offers."""

import ast
import graphlib
import importlib
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

import egad

PACKAGE = Path(egad.__file__).parent
ROOT = Path(__file__).parents[1]
RUNS = ROOT / "egad_workflow"  # a layer too: the commands import it
ABOVE = [  # the line: objects and grasps, without a simulator
    *("errors", "random", "friction", "_util", "plugins", "data", "tables", "geometry", "io"),
    *("grippers", "grasps", "measures", "evolution", "objects"),
]
BELOW = [
    *("evalset", "detectors", "sim", "bench", "report", "learning", "exchange"),
    *("egad_workflow", "cli"),
]
LAYERS = ABOVE + BELOW
OURS = ("egad", "egad_workflow")


@cache
def import_nodes(source):
    """What a module imports, in functions too."""
    kinds = ast.Import | ast.ImportFrom
    return [node for node in ast.walk(ast.parse(source)) if isinstance(node, kinds)]


def imports(source, package):
    """What a module of ours imports from ours, in functions too: (module, name), may be empty.

    Args:
        source: Its text.
        package: The package that it is in, such as `egad.grasps`: relative imports start there.
    """
    for node in import_nodes(source):
        if isinstance(node, ast.Import):
            found = [(alias.name, "") for alias in node.names]
        else:
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            module = ".".join([*(above if node.level else []), *filter(None, [node.module])])
            found = [(module, alias.name) for alias in node.names]
        yield from (each for each in found if each[0].partition(".")[0] in OURS)


def imports_of(path):
    return imports(path.read_bytes(), ".".join(path.relative_to(ROOT).parts[:-1]))


def our_modules():
    return sorted([*PACKAGE.rglob("*.py"), *RUNS.rglob("*.py")])


def part_of(path):
    """The package or top module that a module is in."""
    names = path.relative_to(ROOT).with_suffix("").parts
    return names[0] if path.is_relative_to(RUNS) else names[1]


def imported_parts(path):
    """Packages and top modules of ours that a module imports."""
    for module, name in imports_of(path):
        top, _, inside = f"{module}.{name}".rstrip(".").partition(".")
        if top != "egad":
            yield top
        elif inside:
            yield inside.partition(".")[0]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("import egad.objects, os", [("egad.objects", "")]),
        ("from egad import objects", [("egad", "objects")]),
        ("from egad.objects import load", [("egad.objects", "load")]),
        ("from . import poses", [("egad.grasps", "poses")]),
        ("from .. import objects", [("egad", "objects")]),
        ("from ..measures.grid import labels", [("egad.measures.grid", "labels")]),
        ("def late():\n    import egad.sim", [("egad.sim", "")]),
        ("from egadx import objects", []),
    ],
)
def test_imports_of_all_kinds_are_seen(source, expected):
    assert list(imports(source, "egad.grasps")) == expected


def test_no_module_imports_upwards():
    upwards = [
        f"{path.relative_to(ROOT)} imports {part}"
        for path in our_modules()
        if path.parent != PACKAGE or path.stem in LAYERS
        for part in imported_parts(path)
        if part != "__version__" and LAYERS.index(part) > LAYERS.index(part_of(path))
    ]
    assert upwards == []


def test_every_package_has_its_place():
    found = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert found - {"__init__", "__main__", "__pycache__"} == {*LAYERS} - {RUNS.name}


def test_only_tests_of_the_workflow_import_its_scripts():
    scripts = {path.stem for path in (ROOT / "workflow/scripts").glob("*.py")}
    assert scripts
    importing = [
        f"{path.relative_to(ROOT)} imports {name}"
        for folder in ("egad", "egad_workflow", "tests", "docs", "studies", "examples")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if not path.is_relative_to(ROOT / "tests/workflow")
        for name in top_modules(path)
        if name in scripts
    ]
    assert importing == []


def top_modules(path):
    """The first part of every name that a module imports, but of relative ones."""
    for node in import_nodes(path.read_bytes()):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif node.level == 0:
            yield node.module.partition(".")[0]


def test_packages_are_imported_by_what_they_offer():
    """Another package's names come from its `__init__.pyi`, if it lists them."""
    past = [
        f"{path.relative_to(ROOT)} imports {name} from {source}"
        for path in our_modules()
        for source, name in imports_of(path)
        for package in [offering(source)]
        if package and source != f"egad.{package}" and not path.is_relative_to(folder_of(package))
        if name in offered(package)
    ]
    assert past == []


def offering(module):
    """The innermost package with a stub that a module is, or is in; empty if there is none."""
    package = module.removeprefix("egad").lstrip(".")
    while package and not (folder_of(package) / "__init__.pyi").exists():
        package = package.rpartition(".")[0]
    return package


def folder_of(package):
    return PACKAGE / package.replace(".", "/")


@pytest.mark.parametrize(
    "package",
    [
        ".".join(stub.parent.relative_to(PACKAGE).parts)
        for stub in sorted(PACKAGE.glob("*/**/*.pyi"))
    ],
)
def test_what_a_package_offers_exists(package):
    module = importlib.import_module(f"egad.{package}")
    modules = {path.stem for path in folder_of(package).iterdir()}
    for name in offered(package):
        assert hasattr(module, name), name
        assert name not in modules, f"{name} is a module too: import order would decide which one"


def offered(package):
    """Names that the stub of a package lists."""
    stub = folder_of(package) / "__init__.pyi"
    nodes = ast.walk(ast.parse(stub.read_bytes())) if stub.exists() else ()
    return {node.name for node in nodes if isinstance(node, ast.alias)}


def test_a_class_name_means_one_class():
    modules = defaultdict(list)
    for path in our_modules():
        for node in ast.parse(path.read_bytes()).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                modules[node.name].append(path.relative_to(ROOT).as_posix())
    assert {name: where for name, where in modules.items() if len(where) > 1} == {}


def test_no_modules_import_each_other_in_a_circle():
    modules = {module_name(path): path for path in our_modules()}
    graph = {
        name: {
            found
            for source, member in imports_of(path)
            for found in (f"{source}.{member}", source)
            if found in modules and modules[found].stem != "__init__"
        }
        for name, path in modules.items()
    }
    graphlib.TopologicalSorter(graph).prepare()  # raises CycleError with the circle


def module_name(path):
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)
