"""Results in the cache: the same with and without it, and made again whenever in doubt."""

import os
from multiprocessing import get_context

import numpy as np
import pytest

from egad._util import result_cache
from egad._util.result_cache import cached, source_version
from egad.errors import UserError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("EGAD_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def squared(number, code="1", calls=None):
    def make():
        if calls is not None:
            calls.append(number)
        return {"square": np.array([number**2])}

    return cached("squares", [number], code, make)["square"]


def test_a_result_is_made_once_for_each_input_and_code(folder):
    calls = []
    for number, code in [(2.0, "1"), (2.0, "1"), (3.0, "1"), (3.0, "2"), (2.0, "1")]:
        assert squared(number, code, calls) == number**2
    assert calls == [2.0, 3.0, 3.0]
    assert len(list(folder.rglob("*.npz"))) == 3


def test_inputs_that_look_alike_are_told_apart(folder):
    zeros = np.zeros(4)
    inputs = [
        [zeros],
        [zeros.reshape(2, 2)],
        [zeros.astype(np.int64)],
        [zeros[:2], zeros[2:]],
        [1, 1],
        [11],
        ["1", 1],
        [None],
    ]
    made = [
        cached("k", given, "1", lambda n=n: {"n": np.array(n)}) for n, given in enumerate(inputs)
    ]
    assert [int(each["n"]) for each in made] == list(range(len(inputs)))
    assert len(list(folder.rglob("*.npz"))) == len(inputs)


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04 no more", b"nonsense"])
def test_a_damaged_result_is_made_again(folder, damage):
    squared(2.0)
    (file,) = folder.rglob("*.npz")
    file.write_bytes(damage)
    calls = []
    assert squared(2.0, calls=calls) == 4
    assert squared(2.0, calls=calls) == 4
    assert calls == [2.0]


def test_a_truncated_result_is_made_again(folder):
    squared(2.0)
    (file,) = folder.rglob("*.npz")
    whole = file.read_bytes()
    for length in range(0, len(whole), 7):
        file.write_bytes(whole[:length])
        assert squared(2.0) == 4


def test_nothing_is_kept_if_it_is_off_or_cannot_be_written(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("EGAD_CACHE_DIR", "off")
    assert squared(2.0) == 4
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    monkeypatch.setenv("EGAD_CACHE_DIR", str(tmp_path / "file"))
    assert squared(2.0) == 4


def test_the_cache_is_where_the_user_has_caches(tmp_path, monkeypatch):
    monkeypatch.delenv("EGAD_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    squared(2.0)
    assert list((tmp_path / "egad/squares").glob("*.npz"))


def test_a_relative_folder_is_refused(monkeypatch):
    monkeypatch.setenv("EGAD_CACHE_DIR", "cache")
    with pytest.raises(UserError, match="EGAD_CACHE_DIR is 'cache'; allowed: an absolute path"):
        squared(2.0)


def test_the_oldest_results_are_removed(folder, monkeypatch):
    for number in range(4):
        squared(float(number))
    files = sorted(folder.rglob("*.npz"), key=lambda file: float(np.load(file)["square"][0]))
    for age, file in enumerate(files):
        os.utime(file, (1000.0 * age, 1000.0 * age))
    squared(0.0)  # it is used, and so the newest
    monkeypatch.setattr(result_cache, "MAX_BYTES", 3 * files[0].stat().st_size)
    squared(4.0)
    left = sorted(float(np.load(file)["square"][0]) for file in folder.rglob("*.npz"))
    assert left == [0.0, 9.0, 16.0]


def test_processes_may_write_the_same_result_at_once(folder):
    numbers = [1.0, 2.0] * 20
    with get_context("spawn").Pool(2) as pool:
        assert [float(each[0]) for each in pool.map(squared, numbers)] == [n**2 for n in numbers]
    assert len(list(folder.rglob("*.npz"))) == 2
    assert not list(folder.rglob("*.partial"))


def test_any_change_of_the_code_or_a_library_is_another_version(tmp_path, monkeypatch):
    (tmp_path / "part").mkdir()
    (tmp_path / "part/a.py").write_text("A = 1")
    (tmp_path / "b.py").write_text("B = 1")
    (tmp_path / "c.py").write_text("C = 1")
    monkeypatch.setattr(result_cache, "PACKAGE", tmp_path)

    def version():
        source_version.cache_clear()
        return source_version(("part", "b.py"), ("numpy", "no-such-library"))

    first = version()
    (tmp_path / "c.py").write_text("C = 2")
    assert version() == first
    found = {first}
    for name in ("part/a.py", "b.py"):
        (tmp_path / name).write_text("A = 2")
        found.add(version())
    monkeypatch.setattr(result_cache, "_version", lambda name: f"{name} 2")
    found.add(version())
    assert len(found) == 4
    source_version.cache_clear()
