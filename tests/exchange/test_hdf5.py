import resource
import subprocess
import sys

import h5py
import numpy as np
import pytest

from egad.errors import UserError
from egad.exchange.hdf5 import (
    DamagedError,
    add_array,
    add_group,
    check_key,
    copy_group,
    sound_keys,
    writing,
)


def test_a_copied_group_is_the_same(tmp_path):
    with writing(tmp_path / "a.h5") as file, writing(tmp_path / "b.h5") as other:
        source = add_group(file, "x/y")
        source.attrs.update({"text": "Größe", "number": 1.5, "row": np.arange(3)})
        add_array(source, "data", np.arange(24.0).reshape(2, 3, 4))
        add_array(source, "none", np.empty((0, 3)))
        copy_group(file, other)
        copied = other["x/y"]
        assert (copied["data"][()] == source["data"][()]).all()
        assert (copied["data"].compression, copied["data"].shuffle) == ("gzip", True)
        assert copied["none"].shape == (0, 3)
        assert (copied.attrs["text"], copied.attrs["number"]) == ("Größe", 1.5)
        assert copied.attrs["row"].tolist() == [0, 1, 2]


@pytest.fixture
def part(tmp_path):
    """A small file with numbers and arrays; HDF5 has no checksums of texts."""
    path = tmp_path / "part.h5"
    with writing(path) as file:
        for name in ("a", "b"):
            group = add_group(file, f"objects/{name}")
            group.attrs["mass"] = 0.5
            add_array(group, "data", np.random.default_rng(0).random(500))
    return path


def test_a_file_cut_short_or_damaged_is_one_sentence(part):
    whole = part.read_bytes()
    for content in (whole[:-1], whole[: len(whole) // 2], b"", b"PAR1"):
        part.write_bytes(content)
        with pytest.raises(DamagedError, match=r"part\.h5: truncated or damaged .* make"):
            sound_keys(part, "objects")


def test_damage_is_found_wherever_it_is(part, tmp_path):
    """A file with some zeros in it is refused, or what is copied of it is as it was."""
    whole = part.read_bytes()
    refused = 0
    for start in range(0, len(whole), 64):
        part.write_bytes(whole[:start] + bytes(64) + whole[start + 64 :])
        try:
            assert sound_keys(part, "objects") == ["a", "b"]
        except DamagedError:
            refused += 1
            continue
        with h5py.File(part) as file, writing(tmp_path / "copy.h5") as other:
            copy_group(file["objects"], other)
            for group in other.values():
                assert (group["data"][()] == np.random.default_rng(0).random(500)).all()
                assert dict(group.attrs) == {"mass": 0.5}
    assert refused > 0.5 * len(whole) / 64


def test_what_is_not_there_or_must_not_be_read_is_not_called_damaged(part, tmp_path):
    with pytest.raises(UserError, match="there is no such file"):
        sound_keys(tmp_path / "other.h5", "objects")
    with pytest.raises(UserError, match="cannot be read: Is a directory") as found:
        sound_keys(tmp_path, "objects")
    assert not isinstance(found.value, DamagedError)
    with pytest.raises(DamagedError, match="object 'grasps' doesn't exist"):
        sound_keys(part, "grasps")


FILL = """
import sys, resource, numpy as np
from pathlib import Path
from egad.errors import UserError
from egad.exchange.dexnet_database import add_dataset, add_grasps
from egad.exchange.hdf5 import writing
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, resource.RLIM_INFINITY))
try:
    with writing(Path(sys.argv[1])) as file:
        objects = add_dataset(file, "d", {}, {})
        for number in range(int(sys.argv[2])):
            place = objects.create_group(str(number))
            add_grasps(place, "g", np.random.rand(50, 10), {"q": np.random.rand(50)})
except UserError as error:
    sys.exit(f"egad: {error}")
"""


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_FSIZE"), reason="needs a limit of file sizes")
@pytest.mark.parametrize("objects", [4, 400])
def test_a_disk_that_fills_up_is_one_sentence_and_leaves_no_half_file(tmp_path, objects):
    path = tmp_path / "out.hdf5"
    path.write_text("from before")
    done = subprocess.run(
        [sys.executable, "-c", FILL, path, str(objects)],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1, done.stderr
    assert done.stderr.strip() == f"egad: {path} cannot be written: File too large"
    assert path.read_text() == "from before"
    assert [each.name for each in tmp_path.iterdir()] == ["out.hdf5"]


def test_other_errors_go_through_and_leave_no_file(tmp_path):
    with pytest.raises(ZeroDivisionError), writing(tmp_path / "a.h5"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a/b", "größe", "", ".", "..", "-x", "a b", "a\n", "a\0"])
def test_names_that_are_not_legal_everywhere_are_refused(name):
    with pytest.raises(UserError, match="cannot be exported under this name"):
        check_key(name)
    with pytest.raises(UserError, match=r"^gripper "):
        check_key(name, "gripper")


def test_the_file_opens_in_every_library_since_2008(tmp_path):
    with writing(tmp_path / "a.h5") as file:
        file.create_group("a")
    assert (tmp_path / "a.h5").read_bytes()[8] == 2  # version of the superblock
    with h5py.File(tmp_path / "a.h5", libver=("earliest", "v108")) as file:
        assert "a" in file
