"""Files and modules that users bring."""

import sys

import pytest

from egad.errors import UserError
from egad.plugins import find, named, source_hash


@pytest.fixture
def package(tmp_path, monkeypatch):
    """From the text of its `__init__.py` to an installed package with a module `inner`."""

    def made(name, text):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "__init__.py").write_text(text)
        (folder / "inner.py").write_text("raise RuntimeError('inner ran')\n")
        monkeypatch.syspath_prepend(tmp_path)
        return f"{name}.inner:something"

    yield made
    for name in [name for name in sys.modules if name.startswith("own_package")]:
        del sys.modules[name]


def test_files_of_one_name_in_two_folders_are_two_modules(tmp_path):
    """Dataclasses look for the module that they are in by its name."""
    code = """
from __future__ import annotations
from dataclasses import dataclass
from typing import get_type_hints
class Number({kind}): pass
@dataclass
class Kept:
    number: Number
def kind(): return get_type_hints(Kept)["number"].__mro__[1]
"""
    found = {}
    for kind in (int, str):
        path = tmp_path / kind.__name__ / "mine.py"
        path.parent.mkdir()
        path.write_text(code.format(kind=kind.__name__))
        found[kind] = find(f"{path}:kind", "here", "function")
    assert {kind: tell() for kind, tell in found.items()} == {int: int, str: str}
    assert find(f"{path}:kind", "here", "function") is found[str]


def test_a_fingerprint_runs_the_package_but_not_the_module(package, capsys):
    name = package("own_package", "print('the package ran')")
    assert len(source_hash(name, "here")) == 16
    assert capsys.readouterr().out == "the package ran\n"
    with pytest.raises(UserError, match="cannot be run: RuntimeError: inner ran"):
        find(name, "here", "function")


def test_a_package_that_cannot_be_run_is_the_users_mistake(package):
    name = package("own_package_broken", "1 / 0")
    with pytest.raises(UserError, match=r"no such file or module \(ZeroDivisionError"):
        source_hash(name, "here")


@pytest.mark.parametrize("name", ["nowhere.py:f", "no.such.package:f", "sys:f", ".relative:f"])
def test_what_has_no_file_is_the_users_mistake(name):
    with pytest.raises(UserError, match=f"here: {name}: there is no such file or module"):
        source_hash(name, "here")


@pytest.mark.parametrize(
    "text",
    [
        "def mine(view, gripper, rng): pass\ndef helper(points): pass\n",
        "import os\nclass mine:\n    def __call__(self, view, gripper, rng): pass\n",
        "def mine(view, /, gripper, rng): pass\ndef _other(view, gripper, rng): pass\n",
    ],
)
def test_the_only_thing_that_can_be_meant_needs_no_name(tmp_path, text):
    path = tmp_path / "detector.py"
    path.write_text(text)
    assert named(str(path)) == f"{path}:mine"
    assert named(f"{path}:helper") == f"{path}:helper"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def one(a, b, c): pass\ndef two(a, b, c): pass\n", "several: one, two"),
        ("def one(a): pass\n", "none"),
        ("def one(a:\n", "line 1"),
    ],
)
def test_a_file_in_which_several_or_none_can_be_meant_is_refused(tmp_path, text, said):
    path = tmp_path / "detector.py"
    path.write_text(text)
    with pytest.raises(UserError, match=said):
        named(str(path))
    with pytest.raises(UserError, match="there is no file"):
        named(str(tmp_path / "missing.py"))
