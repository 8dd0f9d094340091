import subprocess
import sys
from textwrap import dedent

import pytest

from egad.pipeline.code_version import code_version, imported

FILES = {
    "__init__.py": "__version__ = '1'\n",
    "config/__init__.py": "from toy.config.base import DEFAULT\n",
    "config/base.py": "DEFAULT = 1\n",
    "unused.py": "X = 1\n",
    "stages/__init__.py": '"""Stages."""\n',
    "stages/evolve.py": """\
        from toy import config
        from toy.config.base import DEFAULT
        from toy.shapes.cppn import query
        import numpy as np

        def run():
            "Docstring."
            from toy.late import later  # imported on first use
            return query() + later()
        """,
    "shapes/__init__.py": "",
    "shapes/cppn.py": "from . import voxels\nfrom ..deep import *\n\ndef query():\n    return 1\n",
    "shapes/voxels.py": "SIZE = 25\n",
    "deep.py": "DEEP = 1\n",
    "late.py": "def later():\n    return 2\n",
    "stages/report.py": "import toy.pages.page\n",
    "pages/__init__.py": "",
    "pages/page.py": "A = 1\n",
    "pages/templates/page.html": "<p>hello</p>\n",
}


@pytest.fixture
def make(tmp_path):
    """A toy package with some files replaced; every call makes a new one."""

    def _make(**changes):
        package = tmp_path / str(len(list(tmp_path.iterdir()))) / "toy"
        package.parent.mkdir()
        replaced = {name.replace("__", "/") + ".py": text for name, text in changes.items()}
        for name, text in (FILES | replaced).items():
            (package / name).parent.mkdir(parents=True, exist_ok=True)
            (package / name).write_text(dedent(text))
        return package

    return _make


def test_finds_every_import_at_any_depth_but_settings(make):
    assert imported("toy.stages.evolve", make()) == {
        "toy.stages",
        "toy.stages.evolve",
        "toy.shapes",
        "toy.shapes.cppn",
        "toy.shapes.voxels",
        "toy.deep",
        "toy.late",
    }


@pytest.mark.parametrize("module", ["shapes__voxels", "deep", "late"])
def test_an_edit_in_an_imported_module_counts(make, module):
    before = code_version("toy.stages.evolve", make())
    assert (
        code_version("toy.stages.evolve", make(**{module: "SIZE = DEEP = later = 3\n"})) != before
    )


def test_an_edit_elsewhere_does_not_count(make):
    before = code_version("toy.stages.evolve", make())
    assert (
        code_version("toy.stages.evolve", make(unused="X = 2\n", pages__page="A = 2\n")) == before
    )


def test_comments_docstrings_and_layout_do_not_count(make):
    before = code_version("toy.stages.evolve", make())
    late = '''\
        """Now with a docstring."""
        # and a comment

        def later(
        ):
            """Two."""
            return (2)
        '''
    assert code_version("toy.stages.evolve", make(late=late)) == before


def test_a_text_that_is_used_counts(make):
    first = make(late="def later():\n    return 'a'\n")
    second = make(late="def later():\n    return 'b'\n")
    assert code_version("toy.late", first) != code_version("toy.late", second)


def test_a_template_counts(make):
    first, second = make(), make()
    (second / "pages/templates/page.html").write_text("<p>good bye</p>\n")
    assert code_version("toy.stages.report", first) != code_version("toy.stages.report", second)
    assert code_version("toy.stages.evolve", first) == code_version("toy.stages.evolve", second)


def test_circular_imports_end(make):
    assert "toy.late" in imported(
        "toy.deep", make(deep="import toy.late\n", late="import toy.deep\n")
    )


def test_a_name_that_a_package_offers_stands_for_its_module(make):
    """Only the module behind the name counts, not its siblings."""
    shapes = "import lazy_loader\n"

    def version(**changes):
        package = make(shapes____init__=shapes, late="from toy.shapes import query\n", **changes)
        (package / "shapes/__init__.pyi").write_text(
            "from .cppn import query as query\nfrom .other import thing as thing\n"
        )
        return code_version("toy.late", package)

    first = version(shapes__other="thing = 1\n")
    assert version(shapes__other="thing = 2\n") == first
    assert version(shapes__other="thing = 1\n", shapes__voxels="SIZE = 3\n") != first


def test_an_unknown_module_is_an_error(make):
    with pytest.raises(ModuleNotFoundError, match=r"toy\.stages\.evlove"):
        code_version("toy.stages.evlove", make())


def test_our_stages_depend_on_the_library_and_not_on_settings_or_each_other():
    modules = imported("egad.pipeline.stages.evolve")
    assert {
        "egad.random",
        "egad.tables.parquet",
        "egad.cppn.query",
        "egad.map_elites.archive",
    } <= modules
    assert not modules & {
        "egad.pipeline.config.stage_settings",
        "egad.pipeline.stages.merge",
        "egad.pipeline.cli",
    }
    assert not any(module.endswith(".parameters") for module in modules)


def test_reading_the_source_finds_what_importing_finds():
    """The slow twin: import a stage, look at what Python loaded."""
    stage = "egad.pipeline.stages.compare"
    code = f"import sys, {stage}; print(*(n for n in sys.modules if n[:4] == 'egad'))"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    names = set(loaded.stdout.split())
    packages = {name.rpartition(".")[0] for name in names}  # some are loaded for parameters only
    # those that only the top module or the definitions of settings import
    by_others = {"egad.grippers.table", "egad.pipeline.exports"}
    expected = {
        name
        for name in names - packages - by_others
        if not name.startswith("egad.pipeline.config") and not name.endswith(".parameters")
    }
    assert imported(stage) - packages == expected
