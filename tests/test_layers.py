"""How packages import each other: downwards in `LAYERS`, and by what a package offers."""

import ast
import importlib
from pathlib import Path

import pytest

import egad

PACKAGE = Path(egad.__file__).parent
LAYERS = [
    *("errors", "random", "outcomes", "_util", "plugins", "data", "tables"),
    *("geometry", "cppn", "reeb", "grasps", "measures", "map_elites", "perception"),
    *("evalset", "stats", "learning", "detectors", "sim", "exchange", "report"),
    *("objects", "api", "trials", "export", "pipeline"),
]


def imported_parts(path):
    """Packages and top modules of egad that a module imports, in functions too."""
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "egad":
            names = [alias.name for alias in node.names] if node.module == "egad" else [node.module]
            yield from (name.removeprefix("egad.").partition(".")[0] for name in names)


def test_no_module_imports_upwards():
    upwards = [
        f"{path.relative_to(PACKAGE)} imports {part}"
        for path in sorted(PACKAGE.rglob("*.py"))
        if path.parent != PACKAGE or path.stem in LAYERS
        for part in imported_parts(path)
        if part != "__version__"
        and LAYERS.index(part) > LAYERS.index(path.relative_to(PACKAGE).with_suffix("").parts[0])
    ]
    assert upwards == []


def test_every_package_has_its_place():
    found = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert found - {"__init__", "__pycache__"} == set(LAYERS)


def test_packages_are_imported_by_what_they_offer():
    """Another package's names come from its `__init__.pyi`, if it lists them."""
    past = [
        f"{path.relative_to(PACKAGE)} imports {alias.name} from {node.module}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_bytes()))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("egad.")
        for package, _, module in [node.module.removeprefix("egad.").partition(".")]
        if module and package != path.relative_to(PACKAGE).parts[0]
        for alias in node.names
        if alias.name in offered(package)
    ]
    assert past == []


@pytest.mark.parametrize("package", [stub.parent.name for stub in sorted(PACKAGE.glob("*/*.pyi"))])
def test_what_a_package_offers_exists(package):
    module = importlib.import_module(f"egad.{package}")
    modules = {path.stem for path in (PACKAGE / package).iterdir()}
    for name in offered(package):
        assert hasattr(module, name), name
        assert name not in modules, f"{name} is a module too: import order would decide which one"


def offered(package):
    """Names that the stub of a package lists."""
    stub = PACKAGE / package / "__init__.pyi"
    nodes = ast.walk(ast.parse(stub.read_bytes())) if stub.exists() else ()
    return {node.name for node in nodes if isinstance(node, ast.alias)}
