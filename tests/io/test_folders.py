import os
import subprocess
import tempfile
import zipfile
from pathlib import Path

import pytest

from egad.errors import UserError
from egad.io.folders import mesh_files, object_names, objects_in, write_zip


@pytest.fixture
def tree(tmp_path):
    """Makes empty files by their paths in a folder."""

    def make(*paths):
        for path in paths:
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).touch()
        return tmp_path

    return make


def test_mesh_files_are_sorted_and_others_passed_over(tree):
    folder = tree("b.STL", "a.obj", "notes.txt", ".hidden.obj", "below/c.obj", "folder.obj/d.obj")
    assert [path.name for path in mesh_files(folder)] == ["a.obj", "b.STL"]


def test_a_folder_without_meshes_says_what_is_allowed(tmp_path):
    with pytest.raises(UserError, match=r"\.obj"):
        mesh_files(tmp_path)
    with pytest.raises(UserError, match=r"no mesh files that match the pattern \*/a\.obj"):
        mesh_files(tmp_path, "*/a.obj")
    with pytest.raises(UserError, match="no such folder"):
        mesh_files(tmp_path / "gone")


@pytest.mark.parametrize("pattern", ["", "/data/*.obj", "**/a/**/*.obj", "."])
def test_a_pattern_that_is_no_glob_in_the_folder_is_named(tree, pattern):
    with pytest.raises(UserError, match="pattern"):
        mesh_files(tree("a.obj"), pattern)


def test_a_pattern_never_leaves_the_folder(tree):
    folder = tree("in/a.obj", "beside/b.obj")
    with pytest.raises(UserError, match="no mesh files"):
        mesh_files(folder / "in", "../beside/*.obj")


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("*", {"top": "top.ply"}),
        ("*/google_16k/nontextured.ply", {"002_can": "002_can/google_16k/nontextured.ply"}),
        (
            "**/nontextured.*",
            {
                "002_can-google_16k": "002_can/google_16k/nontextured.ply",
                "002_can-google_64k": "002_can/google_64k/nontextured.ply",
            },
        ),
        ("002_can/google_64k/textured.ply", {"textured": "002_can/google_64k/textured.ply"}),
    ],
)
def test_the_parts_that_wildcards_match_name_an_object(tree, pattern, names):
    folder = tree(
        "top.ply",
        "002_can/google_16k/nontextured.ply",
        "002_can/google_16k/texture.png",
        "002_can/google_64k/nontextured.ply",
        "002_can/google_64k/textured.ply",
        ".cache/google_16k/nontextured.ply",
    )
    assert objects_in(folder, pattern) == {name: folder / path for name, path in names.items()}


def test_folders_may_be_links(tree, tmp_path):
    folder = tree("kept/scan/mesh.ply", "data/a.txt") / "data"
    (folder / "mug").symlink_to(tmp_path / "kept")
    assert objects_in(folder, "*/scan/mesh.ply") == {"mug": folder / "mug/scan/mesh.ply"}


@pytest.mark.parametrize("pattern", ["**/*.obj", "**", "**/*", "./**/*.obj"])
def test_two_stars_follow_links_and_cycles_end(tree, tmp_path, pattern):
    """As `find -L` does: a file has each of its names, but no path passes a folder twice."""
    folder = tree("real/sub/a.obj", "data/b.obj", "data/.git/c.obj", "data/in/d.obj") / "data"
    (folder / "linked").symlink_to("../real")
    (folder / "linked/sub/round").symlink_to(folder)
    (folder / "in/self").symlink_to(".")
    (folder / "in/file.obj").symlink_to("../b.obj")
    (folder / "gone").symlink_to("nowhere")
    (folder / "loop").symlink_to("loop")
    found = ["b.obj", "in/d.obj", "in/file.obj", "linked/sub/a.obj"]
    assert mesh_files(folder, pattern) == [folder / path for path in found]
    listed = subprocess.run(
        ["find", "-L", ".", "-name", "*.obj", "-not", "-path", "*/.*/*"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert sorted(listed.stdout.split()) == [f"./{path}" for path in found]
    assert list(objects_in(tmp_path, "data/**/a.obj")) == ["linked-sub"]
    assert mesh_files(tmp_path, "data/l*/**/*.obj") == [folder / "linked/sub/a.obj"]


@pytest.fixture
def folder_of_a_person():
    """A folder of a user whom permissions bind, as they do not bind root."""
    person = os.geteuid()
    os.seteuid(person or 65534)
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)
    os.seteuid(person)


def test_a_folder_that_cannot_be_read_is_left_out_with_a_warning(folder_of_a_person, caplog):
    folder = folder_of_a_person
    (folder / "a.obj").touch()
    (folder / "lost+found").mkdir(mode=0)
    for pattern in ("**/*.obj", "*.obj"):
        assert mesh_files(folder, pattern) == [folder / "a.obj"]
    (warning,) = caplog.messages
    assert warning.startswith(f"{folder / 'lost+found'} is left out: it cannot be read")
    with pytest.raises(UserError, match=r"lost\+found: cannot be read"):
        mesh_files(folder / "lost+found", "**/*.obj")


@pytest.mark.parametrize("pattern", ["a**/*.obj", "**.obj", "**/**"])
def test_two_stars_are_the_whole_name_of_a_folder(tree, pattern):
    with pytest.raises(UserError, match="only once, as the whole name"):
        mesh_files(tree("a/b.obj"), pattern)


def test_names_are_safe_in_paths():
    files = map(Path, ["mug.obj", "caf\xe9 au lait.obj", "..obj", "-x.stl", "a.b.obj"])
    assert list(object_names(files)) == ["mug", "caf__au_lait", "object", "x", "a.b"]


CLASHING = [
    *("x/part.obj", "y/part.obj", "part.stl", "part-obj.ply"),
    *("a b.obj", "a_b.obj", "Mug.obj", "mug.obj", "mug.OBJ", "Cup.obj", "cup.obj"),
]


def test_names_are_unique_on_every_disk():
    names = object_names([Path(path) for path in CLASHING])
    assert len({name.lower() for name in names}) == len(CLASHING) == len(set(names.values()))


@pytest.mark.parametrize("added", CLASHING)
def test_a_name_never_goes_to_another_file(added):
    before = object_names([Path(path) for path in CLASHING if path != added])
    after = object_names([Path(path) for path in CLASHING])
    assert all(after.get(name, path) == path for name, path in before.items())


def folder_with(path, texts, time):
    for name, text in texts.items():
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).write_text(text)
        (path / name).chmod(0o600)
        os.utime(path / name, (time, time))
    return path


def test_the_same_files_give_the_same_bytes(tmp_path):
    texts = {"A0/b.txt": "b", "A0/a.txt": "a" * 1000}
    first = folder_with(tmp_path / "first", texts, 1e9)
    second = folder_with(tmp_path / "second", dict(reversed(texts.items())), 1.5e9)
    (second / "A0/a.txt").chmod(0o755)
    for name, folder in (("1.zip", first), ("2.zip", second)):
        write_zip(tmp_path / name, [folder])
    assert (tmp_path / "1.zip").read_bytes() == (tmp_path / "2.zip").read_bytes()


def test_linked_folders_are_packed(tmp_path):
    folder_with(tmp_path / "kept", {"deep/a.txt": "a"}, 1e9)
    folder = folder_with(tmp_path / "folder", {"b.txt": "b"}, 1e9)
    (folder / "linked").symlink_to(tmp_path / "kept")
    (folder / "round").symlink_to(folder)
    write_zip(tmp_path / "1.zip", [folder])
    with zipfile.ZipFile(tmp_path / "1.zip") as archive:
        assert archive.namelist() == ["b.txt", "linked/deep/a.txt"]
        assert archive.read("linked/deep/a.txt") == b"a"
