"""No module imports upwards: each package knows only those before it in `LAYERS`."""

import ast
from pathlib import Path

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
