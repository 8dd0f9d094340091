import os
import re
import shutil
import sys
from functools import cache
from pathlib import Path
from textwrap import dedent

import postprocess
import pytest
import rescale
import trimesh
from rule_texts import COPIES, OWN, TEXT, script_of

from egad.config import DatasetSection, Postprocess, Settings
from egad.config.stages import PostprocessSolids, RescaleMeshes, select
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad.tables.objects import SOLIDS
from egad.workflow.code_version import PACKAGE, code_version, used_names
from egad.workflow.definitions import read_module

ROOT = Path(__file__).parents[2]

FILES = {
    "__init__.py": "__version__ = '1'\n",
    "config/__init__.py": "from toy.config.base import DEFAULT\n",
    "config/base.py": "DEFAULT = 1\nOTHER = 1\n",
    "unused.py": "X = 1\n",
    "../scripts/evolve.py": """\
        from toy import config
        from toy.config import DEFAULT
        from toy.shapes.cppn import query
        from toy.shapes.parameters import Shape
        import numpy as np

        def run(shape: Shape):
            "Docstring."
            from toy.late import later  # imported on first use
            return query(shape.size) + later() + np.pad(DEFAULT, 1)
        """,
    "shapes/__init__.py": "",
    "shapes/parameters.py": """\
        PADS = {"soft": 0.8}
        LEAST = 1

        class Shape:
            size: int = Field(3, ge=1, description="voxels along a side")

            @model_validator(mode="after")
            def _size_is_odd(self):
                return self

            @property
            def pad(self):
                return PADS["soft"]
        """,
    "shapes/cppn.py": """\
        from . import voxels
        from ..deep import *

        def query(size, times=2):
            return table["one"](size) * times * DEEP

        def one(size):
            return voxels.SIZE

        def nobody():
            return voxels.OTHER

        table = {"one": one}
        """,
    "shapes/voxels.py": "SIZE = 25\nOTHER = 1\n",
    "deep.py": "DEEP = 1\n",
    "late.py": "STEPS = []\n\ndef later():\n    return STEPS\n\nSTEPS.append(2)\n",
    "../scripts/report.py": "from toy.pages.page import fill\n\nfill('page.html')\n",
    "pages/__init__.py": "",
    "pages/page.py": "def fill(name):\n    return name\n",
    "pages/templates/page.html": "<p>{{ view.size }}</p>{% include 'page.css' %}\n",
    "pages/templates/page.css": "p {}\n",
    "pages/templates/other.css": "p {}\n",
    "../scripts/grasp.py": """\
        from toy.shapes.parameters import Shape

        def run(shape: Shape):
            return shape.pad
        """,
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
    return {stage: code_version(script(package, stage), package) for stage in STAGES}


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
    ("name", "old", "new"),
    [
        ("shapes/voxels.py", "SIZE = 25", "SIZE = 26"),  # through a name of a module
        ("config/base.py", "DEFAULT = 1", "DEFAULT = 2"),  # through a package
        ("deep.py", "DEEP = 1", "DEEP = 2"),  # through a star
        ("late.py", "append(2)", "append(3)"),  # a statement that defines nothing
        ("shapes/cppn.py", "times=2", "times=3"),  # a default of a function
        ("shapes/cppn.py", "return voxels.SIZE", "return 3"),  # called from a table
    ],
)
def test_what_a_stage_uses_counts_wherever_it_is_defined(rerun, name, old, new):
    assert rerun((name, old, new)) == {"evolve"}


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("unused.py", "X = 1", "X = 2"),
        ("config/base.py", "OTHER = 1", "OTHER = 2"),
        ("shapes/cppn.py", "return voxels.OTHER", "return 3"),
        ("shapes/parameters.py", "LEAST = 1", "LEAST = 2"),
        ("__init__.py", "'1'", "'2'"),
        ("../scripts/evolve.py", "Docstring", "Another docstring"),
        ("../scripts/evolve.py", "  # imported on first use", ""),
        ("shapes/cppn.py", "(size) * times", "(\n    size\n) * times"),
        ("pages/templates/other.css", "p {}", "a {}"),
    ],
)
def test_what_no_stage_uses_does_not_count(rerun, name, old, new):
    assert rerun((name, old, new)) == set()


def test_of_settings_defaults_count_and_what_only_describes_or_checks_them_does_not(rerun):
    """A stage gets values that were checked before."""
    settings = "shapes/parameters.py"
    assert rerun((settings, "Field(3", "Field(5")) == {"evolve", "grasp"}
    assert rerun((settings, "voxels along a side", "number of voxels")) == set()
    assert rerun((settings, "ge=1", "ge=2")) == set()
    assert rerun((settings, "return self\n", "return None\n")) == set()


def test_methods_of_settings_count_where_they_are_used(rerun):
    """`np.pad` in another stage is not meant."""
    assert rerun(("shapes/parameters.py", "0.8", "0.2")) == {"grasp"}


@pytest.mark.parametrize("name", ["page.html", "page.css"])
def test_a_template_counts_where_it_is_named_or_included(rerun, name):
    old = "<p>" if name == "page.html" else "p {}"
    assert rerun((f"pages/templates/{name}", old, "a {}")) == {"report"}


def test_circular_imports_end(make):
    circle = [
        ("deep.py", "DEEP = 1", "import toy.late\nDEEP = toy.late.later"),
        ("late.py", "return STEPS", "import toy.deep\n    return toy.deep.DEEP"),
    ]
    assert ("toy.late", "later") in used_names("toy.deep", make(*circle))


def test_a_name_that_a_package_offers_stands_for_its_module(make):
    """Only the definition behind the name counts, not its siblings."""

    def version(*changes):
        package = make(
            ("shapes/__init__.py", "", "import lazy_loader\n"),
            ("late.py", "STEPS = []", "from toy.shapes import query\nSTEPS = [query]"),
            *changes,
        )
        (package / "shapes/__init__.pyi").write_text(
            "from .cppn import query as query\nfrom .voxels import OTHER as OTHER\n"
        )
        return code_version("toy.late", package)

    assert version(("shapes/voxels.py", "OTHER = 1", "OTHER = 2")) == version()
    assert version(("shapes/voxels.py", "SIZE = 25", "SIZE = 3")) != version()


def test_modules_have_versions_as_scripts_have(make):
    def version(*changes):
        return code_version("toy.shapes.cppn", make(*changes))

    assert version(("deep.py", "DEEP = 1", "DEEP = 2")) != version()
    assert version(("shapes/parameters.py", "Field(3", "Field(5")) == version()


def test_it_does_not_matter_where_a_script_and_the_package_are(make, tmp_path, monkeypatch):
    """Each call makes them elsewhere, and Snakemake hands a copy of a script."""
    package = make()
    assert versions(package) == versions(make())
    elsewhere = shutil.copy(script(package, "evolve"), tmp_path / "evolve.py")
    monkeypatch.chdir(tmp_path)
    expected = code_version(script(package, "evolve"), package)
    for path in (elsewhere, str(elsewhere), "evolve.py"):
        assert code_version(path, package) == expected


@pytest.mark.parametrize("name", ["toy.evlove", "scripts/evlove.py"])
def test_an_unknown_module_or_script_is_an_error(make, name):
    with pytest.raises(ModuleNotFoundError, match=re.escape(name)):
        code_version(name, make())


SEARCHED = {"search_failures", "join_failures"}  # these label, simulate and breed themselves
EXPLAINED = SEARCHED | {"explain_failures"}  # films attempts, and draws maps
TRIED = {"simulate", "clutter", "agreement", "simulated_label", "naive_grasp"} | EXPLAINED
TRIED |= {"render", "scenes"}
RATED = {"evolve", "postprocess", "graspability", "grasp_label", "size_effect", "render"} | SEARCHED
# objects, and the jaws of hands from files
DECOMPOSED = {"bundle", "convex_parts", "grasp_label", "report"} | TRIED
SHAPED = {"evolve", "postprocess", "gallery"} | EXPLAINED
WEIGHED = {"bundle", "convex_parts", "dexnet_objects", "naive_grasp", "print_export"}
WEIGHED |= {"release_archive", "scenes", "simulated_label", "explain_failures"}
WEIGHED |= RATED  # cups bear the weight
BRED = {"evolve", "merge", "publish", "ancestry", "postprocess"} | EXPLAINED
BRED |= {"gallery", "release_tables", "scenes", "scene_card"}  # lines of descent
PRINTED = {"print_export", "datasheet"}
SCRIPTS = ROOT / "workflow/scripts"
RULES = set(re.findall(r'code_of(?:_format)?\("(\w+)"\)', TEXT))
# What is changed, and the stages that use it. Written by hand, from what they do: the report draws
# scenes of a simulation and lists all settings; the gallery reads those of evolution.
USED = [
    ("grippers/parameters.py", "Pad(0.8, ", "Pad(0.2, ", TRIED | {"report"}),
    ("sim/world.py", "GRAVITY = 9.81", "GRAVITY = 1.62", TRIED | {"report"}),
    ("evalset/print_poses.py", "LAYER = 0.0002", "LAYER = 0.0003", PRINTED),
    ("evalset/datasheet.py", "ATTEMPTS = 20", "ATTEMPTS = 10", {"datasheet"}),
    (
        "evolution/variation.py",
        "MIN_WEIGHT = 0.25",
        "MIN_WEIGHT = 0.5",
        {"evolve", "search_failures"},
    ),
    ("geometry/convex_parts.py", "SLIVER = 1e-6", "SLIVER = 1e-5", DECOMPOSED),
    ("evalset/plate_files.py", "MILLIMETRES = 1000.0", "MILLIMETRES = 1.0", {"print_export"}),
    ("bench/stats/rates.py", "DRAWS = 10_000", "DRAWS = 1_000", {"report", "explain_failures"}),
    # code
    ("evalset/selection.py", "range(restarts)", "range(1)", {"select_eval"}),
    ("geometry/mass.py", "/ size)", "/ (2 * size))", WEIGHED),
    ("measures/size_effect.py", "opening / side", "opening", {"size_effect"}),
    # defaults of functions
    ("grasps/quality.py", "friction: ArrayLike = 0.5,", "friction: ArrayLike = 0.4,", RATED),
    # defaults, bounds and descriptions of settings
    ("evolution/parameters.py", "Field(VOXELS, ge=8", "Field(24, ge=8", SHAPED | {"report"}),
    ("evolution/parameters.py", "Field(VOXELS, ge=8", "Field(VOXELS, ge=9", set()),
    ("evolution/parameters.py", "voxels along each side", "number of voxels on a side", set()),
    ("evalset/parameters.py", "Field(0.005,", "Field(0.006,", PRINTED | {"report"}),
    # columns of tables
    ("tables/evolution.py", "bias of each node", "biases", BRED),
    # templates
    ("report/templates/map.html.j2", "<section", "<section hidden", {"report"}),
    ("report/templates/scene3d.js", "function", "function  ", {"report", "gallery"}),
    ("report/templates/gallery.css", "{", "{ ", {"gallery"}),
    ("report/templates/page.css", "{", "{ ", {"report", "gallery", "explain_failures"}),
    ("report/templates/view.html.j2", "<", " <", set()),  # of a command
    # how results print and are plotted decides none of them
    ("report/notebook.py", "THUMBNAIL = 160", "THUMBNAIL = 80", set()),
    ("report/live_map.py", "UNIT = 40", "UNIT = 20", {"explain_failures"}),
    # data: the released archive is an input of the rule `archive`, which Snakemake compares
    ("data/evaluation_set.csv", "A0", "A1", {"explain_failures"}),
]


@pytest.mark.parametrize(
    ("file", "old", "new", "stages"),
    USED,
    ids=lambda each: each[:40] if isinstance(each, str) else "and".join(sorted(each)),
)
def test_our_stages_run_again_for_what_they_use_and_for_nothing_else(
    tmp_path, file, old, new, stages
):
    package = tmp_path / "egad"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, package, ignore=ignored, copy_function=os.symlink)
    text = (package / file).read_text(encoding="utf-8")
    assert old in text
    (package / file).unlink()
    (package / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    assert {stage for stage in RULES if _version(stage, package) != _version(stage)} == stages


@cache
def _version(stage, package=PACKAGE):
    return code_version(SCRIPTS / f"{stage}.py", package)


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
        imported = set().union(*read_module(PACKAGE, str(path)).imports.values())
        assert not {name.partition(".")[0] for name in imported} & names, path


def test_every_other_file_of_a_package_is_named_in_full_by_something():
    """A name that is put together from pieces would not be found."""
    files = [
        path
        for path in PACKAGE.rglob("*")
        if path.is_file()
        and "__pycache__" not in path.parts
        and path.suffix not in (".py", ".pyi", ".typed")
    ]
    sources = [*PACKAGE.rglob("*.py"), *(path for path in files if path.suffix != ".parquet")]
    texts = [path.read_bytes() for path in sources]
    for path in files:
        names = (f'"{each}"'.encode() for each in (path.name, path.parent.name))
        assert any(name in text for name in names for text in texts), path


def test_what_runs_in_a_stage_is_what_was_found_in_its_source(tmp_path):
    """The slow twin: run stages, and look at which functions are called."""
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
    calls = set()

    def note(frame, event, _):
        if event == "call":
            calls.add((frame.f_globals.get("__name__", ""), frame.f_code.co_qualname))

    sys.setprofile(note)
    try:
        function(*arguments)
    finally:
        sys.setprofile(None)
    own, path = function.__module__, function.__code__.co_filename
    expected = {(own if module == path else module, name) for module, name in used_names(path)}
    made_by_python = ("<", "__create_fn__")  # by comprehensions and data classes
    seen = {
        (module, name.split(".")[0])
        for module, name in calls
        if module.startswith(("egad.", own)) and not name.startswith(made_by_python)
    }
    assert len(seen) > 20
    assert (own, "run") in seen
    assert seen - expected == set()
