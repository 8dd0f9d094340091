"""All formats of objects together."""

import importlib.util
from typing import get_args

import pytest

from egad.errors import UserError
from egad.exchange import MeshFormat, PhysicsFormat
from egad.exchange.formats import MESH_WRITERS, PHYSICS_WRITERS, check_installed


def write(name, folder, made):
    if name in MESH_WRITERS:
        MESH_WRITERS[name](folder, "ell", made.mesh)
    else:
        PHYSICS_WRITERS[name](folder, "ell", made, 0.4)


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_every_name_has_a_writer():
    assert set(get_args(MeshFormat)) == set(MESH_WRITERS)
    assert set(get_args(PhysicsFormat)) == set(PHYSICS_WRITERS)


@pytest.mark.parametrize("name", [*MESH_WRITERS, *PHYSICS_WRITERS])
def test_the_same_object_gives_the_same_bytes(tmp_path, made, name):
    if name == "usd":
        pytest.importorskip("pxr")
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        write(name, folder, made)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert contents(tmp_path / "a")


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(UserError, match=r"usd needs OpenUSD: pip install 'egad\[usd\]'"):
        check_installed("usd")
    check_installed("sdf")
