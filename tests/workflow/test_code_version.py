import os
import re
import shutil
import sys
from textwrap import dedent

import postprocess
import pytest
import rescale
import trimesh
from rule_texts import COPIES, OWN, TEXT, script_of

from egad.evolution import PostprocessSolids
from egad.exchange import RescaleMeshes
from egad.measures import Postprocess
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad.tables.objects import SOLIDS
from egad_workflow.code_version import PACKAGES, code_version, imported_modules, read_module
from egad_workflow.datasets import DatasetSection
from egad_workflow.settings import Settings, select

PACKAGE = PACKAGES[0]
SCRIPTS = PACKAGE.parent / "workflow/scripts"

FILES = {
    "__init__.py": "__version__ = '1'\n",
    "unused.py": "X = 1\n",
    "../scripts/evolve.py": """\
        from toy import config
        from toy.shapes.cppn import query
        from toy.shapes.parameters import Shape
        import numpy as np

        def run(shape: Shape):
            "Docstring."
            from toy.late import later  # imported on first use
            return query(shape.size) + later() + np.pad(config.DEFAULT, 1)
        """,
    "config/__init__.py": "from toy.config.base import DEFAULT\n",
    "config/base.py": "DEFAULT = 1\n",
    "shapes/__init__.py": "import lazy_loader\n",
    "shapes/__init__.pyi": "from .cppn import query as query\nfrom .voxels import SIZE as SIZE\n",
    "shapes/parameters.py": """\
        class Shape:
            size: int = Field(3, ge=1, description="voxels along a side")
        """,
    "shapes/cppn.py": """\
        from typing import TYPE_CHECKING

        from ..deep import *

        if TYPE_CHECKING:
            from . import voxels

        def query(size, times=2):
            return size * times * DEEP
        """,
    "shapes/voxels.py": "SIZE = 25\n",
    "deep.py": "DEEP = 1\n",
    "late.py": "def later():\n    return 2\n",
    "../scripts/report.py": "from toy.pages.page import fill\n\nfill('page.html')\n",
    "pages/__init__.py": "",
    "pages/page.py": "def fill(name):\n    return name\n",
    "pages/templates/page.html": "<p>{{ view.size }}</p>{% include 'page.css' %}\n",
    "pages/templates/page.css": "p {}\n",
    "pages/templates/other.css": "p {}\n",
    "../scripts/grasp.py": "from toy.shapes import SIZE\n",
}
STAGES = ("evolve", "report", "grasp")


@pytest.fixture
def make(tmp_path):
    """A toy package, and scripts beside it, with some texts replaced; every call makes new ones."""

    def _make(*changes):
        package = tmp_path / str(len(list(tmp_path.iterdir()))) / "toy"
        for name, text in FILES.items():
            (package / name).parent.mkdir(parents=True, exist_ok=True)
            (package / name).write_text(dedent(text))
        for name, old, new in changes:
            change(package / name, old, new)
        return package

    return _make


def change(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1, (path, old)
    path.write_text(text.replace(old, new), encoding="utf-8")


def versions(package):
    return {stage: code_version(script(package, stage), (package,)) for stage in STAGES}


def script(package, stage):
    return package.parent / f"scripts/{stage}.py"


@pytest.fixture
def rerun(make):
    """The stages whose version is different after a change."""

    def _rerun(*changes):
        before, after = versions(make()), versions(make(*changes))
        return {stage for stage in STAGES if before[stage] != after[stage]}

    return _rerun


@pytest.mark.parametrize(
    ("name", "old", "new", "stages"),
    [
        ("config/base.py", "DEFAULT = 1", "DEFAULT = 2", {"evolve"}),  # through a package
        ("shapes/voxels.py", "SIZE = 25", "SIZE = 26", {"grasp"}),  # that a package offers
        ("shapes/__init__.py", "import lazy", "import very_lazy", {"evolve", "grasp"}),
        ("deep.py", "DEEP = 1", "DEEP = 2", {"evolve"}),  # through a star
        ("late.py", "return 2", "return 3", {"evolve"}),  # imported in a function
        ("shapes/cppn.py", "times=2", "times=3", {"evolve"}),
        ("shapes/parameters.py", "Field(3", "Field(5", {"evolve"}),
        ("pages/templates/page.html", "<p>", "<p class='a'>", {"report"}),
        ("pages/templates/page.css", "p {}", "a {}", {"report"}),  # included by the page
    ],
)
def test_a_module_or_named_file_counts_for_what_imports_it(rerun, name, old, new, stages):
    assert rerun((name, old, new)) == stages


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("unused.py", "X = 1", "X = 2"),
        ("__init__.py", "'1'", "'2'"),  # the version of a release
        ("shapes/parameters.py", "voxels along a side", "number of voxels"),
        ("shapes/parameters.py", "ge=1", "ge=2"),
        ("../scripts/evolve.py", "Docstring", "Another docstring"),
        ("../scripts/evolve.py", "  # imported on first use", ""),
        ("shapes/cppn.py", "size * times", "(\n    size\n) * times"),
        ("pages/templates/other.css", "p {}", "a {}"),
    ],
)
def test_what_no_stage_imports_and_what_changes_no_result_does_not_count(rerun, name, old, new):
    assert rerun((name, old, new)) == set()


def test_circular_imports_end(make):
    circle = [
        ("deep.py", "DEEP = 1", "import toy.late\nDEEP = toy.late.later"),
        ("late.py", "return 2", "import toy.deep\n    return toy.deep.DEEP"),
    ]
    assert set(imported_modules("toy.deep", (make(*circle),))) == {"toy.deep", "toy.late"}


def test_a_package_that_is_used_as_a_whole_counts_with_all_that_it_offers(make):
    package = make(("late.py", "def later", "from toy import shapes\n\n\ndef later"))
    assert {"toy.shapes.cppn", "toy.shapes.voxels"} < set(imported_modules("toy.late", (package,)))


def test_it_does_not_matter_where_a_script_and_the_package_are(make, tmp_path, monkeypatch):
    """Each call makes them elsewhere, and Snakemake hands a copy of a script."""
    package = make()
    assert versions(package) == versions(make())
    elsewhere = shutil.copy(script(package, "evolve"), tmp_path / "evolve.py")
    monkeypatch.chdir(tmp_path)
    expected = code_version(script(package, "evolve"), (package,))
    fetched = shutil.copy(elsewhere, tmp_path / "evolve.py@1f2e3d")  # from a repository
    for path in (elsewhere, str(elsewhere), "evolve.py", fetched):
        assert code_version(path, (package,)) == expected


@pytest.mark.parametrize("name", ["toy.evlove", "scripts/evlove.py"])
def test_an_unknown_module_or_script_is_an_error(make, name):
    with pytest.raises(ModuleNotFoundError, match=re.escape(name)):
        code_version(name, (make(),))


RULES = set(re.findall(r'code_of(?:_format)?\("(\w+)"\)', TEXT))
# What is changed, some stages that import it, and some that do not: written by hand.
USED = [
    (
        "sim/world.py",
        "GRAVITY = 9.81",
        "1.62",
        "simulate clutter report",
        "evolve postprocess bundle",
    ),
    (
        "evolution/variation.py",
        "MIN_WEIGHT = 0.25",
        "0.5",
        "evolve",
        "rescale simulate bundle join",
    ),
    ("geometry/convex_parts.py", "SLIVER = 1e-6", "1e-5", "bundle simulate", "join publish"),
    ("bench/stats/rates.py", "DRAWS = 10_000", "1_000", "report", "simulate evolve bundle"),
    ("report/archive_map.py", "UNIT = 40", "20", "", "evolve postprocess report"),
    ("evalset/datasheet.py", "ATTEMPTS = 20", "10", "datasheet", "evolve bundle simulate"),
    ("report/templates/map.html.j2", "<section", "<div", "report", "evolve simulate bundle"),
    ("report/templates/gallery.css", "{", "{ ", "gallery", "report evolve"),
    ("report/templates/view.html.j2", "<", " <", "", "compare evolve"),  # of a command
    (
        "evolution/parameters.py",
        "Field(VOXELS, ge=8",
        "Field(24, ge=8",
        "evolve",
        "bundle join",
    ),
    ("evolution/parameters.py", "Field(VOXELS, ge=8", "Field(VOXELS, ge=9", "", "evolve report"),
    ("cli/rescale.py", "Scale meshes", "Scale", "", " ".join(RULES)),
]


@pytest.mark.parametrize(("file", "old", "new", "stages", "others"), USED)
def test_our_stages_run_again_for_what_they_use_and_not_for_other_work(
    tmp_path, file, old, new, stages, others
):
    package = tmp_path / "egad"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, package, ignore=ignored, copy_function=os.symlink)
    text = (package / file).read_text(encoding="utf-8")
    assert old in text
    new = f"{old.partition(' = ')[0]} = {new}" if " = " in old else new
    (package / file).unlink()
    (package / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    changed = {
        stage
        for stage in [*stages.split(), *others.split()]
        if _version(stage, package) != _version(stage)
    }
    assert changed == set(stages.split())


def _version(stage, package=PACKAGE):
    return code_version(SCRIPTS / f"{stage}.py", (package, *PACKAGES[1:]))


@pytest.mark.parametrize("rule", [*OWN, *COPIES])
def test_a_rule_has_the_version_of_the_code_that_it_runs(rule):
    text = OWN[rule] if rule in OWN else COPIES[rule][1]
    (code,) = re.findall(r"^ {8}code=(.*)$", text, flags=re.MULTILINE)
    assert code == OTHERWISE.get(rule, f'code_of("{script_of(rule)}"),')


# That of a format too, which is a module.
OTHERWISE = {name: f'code_of_format("{name}"),' for name in ("export", "release_archive")}


def test_a_script_imports_no_other_script():
    """What it used of one would not count."""
    names = {path.stem for path in SCRIPTS.glob("*.py")}
    for path in SCRIPTS.glob("*.py"):
        imported = {module.partition(".")[0] for module, _ in read_module(str(path)).imports}
        assert not imported & names, path


def test_every_other_file_of_a_package_is_named_in_full_by_something():
    """A name that is put together from pieces would not be found."""
    files = [
        path
        for path in PACKAGE.rglob("*")
        if path.is_file()
        and "__pycache__" not in path.parts
        and path.suffix not in (".py", ".pyi", ".typed")
    ]
    modules = [path for package in PACKAGES for path in package.rglob("*.py")]
    sources = [*modules, *(path for path in files if path.suffix != ".parquet")]
    texts = [path.read_bytes() for path in sources]
    for path in files:
        names = (f'"{each}"'.encode() for each in (path.name, path.parent.name))
        assert any(name in text for name in names for text in texts), path


def test_what_runs_in_a_stage_is_what_was_found_in_its_source(tmp_path):
    """The slow twin: run stages, and look at the modules of the functions that are called."""
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box([0.06, 0.04, 0.03]).export(tmp_path / "meshes/box.obj")
    whole = Settings(postprocess=Postprocess(max_candidates=64))
    wanted = select(whole, RescaleMeshes, "panda")
    _check_calls(rescale.run, wanted, tmp_path / "meshes", tmp_path / "scaled")
    assert len(parquet.read(tmp_path / "scaled/scales.parquet", SCALES)) == 1
    measured = select(whole, PostprocessSolids)
    tables = (tmp_path / "solids.parquet", tmp_path / "rejected.parquet")
    dataset = DatasetSection(source="primitives", objects=1)
    _check_calls(postprocess.run, measured, dataset, (0, 1), *tables)
    assert len(parquet.read(tables[0], SOLIDS)) == 1


def _check_calls(function, *arguments):
    seen = set()

    def note(frame, event, _):
        if event == "call":
            seen.add(frame.f_globals.get("__name__", ""))

    sys.setprofile(note)
    try:
        function(*arguments)
    finally:
        sys.setprofile(None)
    ours = {name for name in seen if name.startswith("egad")} - {"egad"}
    assert len(ours) > 10
    assert ours <= set(imported_modules(function.__code__.co_filename))
