"""What a configuration names and cannot be read is said before anything runs."""

import os
from pathlib import Path

import pandas as pd
import pytest
import trimesh

from egad.errors import UserError
from egad_workflow.check import check
from egad_workflow.input_files import check_input_files, check_readable


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working directory with a mesh in `parts`, which is also the home directory."""
    (tmp_path / "parts").mkdir()
    trimesh.creation.box().export(tmp_path / "parts/box.stl")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


def meshes(path, **more):
    return {"datasets": {"m": {"source": "meshes", "folder": path, "units": "mm"}}, **more}


def problems(config):
    """The lines about a configuration of which the evolved dataset is no part."""
    settings = check({"targets": {"datasets": []}, **config})
    try:
        check_input_files(settings)
    except UserError as error:
        return str(error).split("\n")
    return []


@pytest.mark.parametrize(
    ("content", "reason"),
    [(b"no table", "not a readable Parquet file"), (None, "columns are missing: ")],
)
def test_an_archive_that_is_none_is_refused(folder, content, reason):
    path = folder / "archive.parquet"
    if content is None:
        pd.DataFrame({"id": ["a"]}).to_parquet(path)
    else:
        path.write_bytes(content)
    config = {"datasets": {"old": {"source": "archive", "archive": "archive.parquet"}}}
    (line,) = problems(config)
    assert line.startswith("datasets.old: archive.parquet: ")
    assert reason in line


@pytest.mark.usefixtures("folder")
def test_a_file_of_labels_is_looked_for_and_words_are_not():
    for word in (None, "all", "cells", "names"):
        own = meshes("parts")
        own["datasets"]["m"]["evaluation_set"] = word
        assert problems(own) == []
        data = check({"targets": {"datasets": []}, **own}).datasets["m"]
        assert data.selection == (word or "all")
    own["datasets"]["m"]["evaluation_set"] = "labels.csv"
    assert problems(own) == ["datasets.m: labels.csv does not exist"]


@pytest.mark.parametrize("path", ["parts", "~/parts", "./parts/", "link", "~/link"])
def test_a_folder_may_be_relative_a_link_or_in_the_home_directory(folder, path):
    (folder / "link").symlink_to("parts")
    assert problems(meshes(path)) == []
    chosen = check(meshes(path, targets={"datasets": []})).datasets["m"]
    assert Path(chosen.folder).samefile(folder / "parts")


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("partz", "partz: there is no such folder of meshes; did you mean parts?"),
        ("Parts", "Parts: there is no such folder of meshes; did you mean parts?"),
        ("~/partz", "{home}/partz: there is no such folder of meshes; did you mean {home}/parts?"),
        ("nowhere/at all", "nowhere/at all: there is no such folder of meshes"),
        ("empty", "empty: no mesh files in it; allowed endings: .3mf .glb .obj .off .ply .stl"),
        ("parts/box.stl", "parts/box.stl: is a file, not a folder of meshes"),
        ("parts/box.stl/more", "parts/box.stl/more: there is no such folder of meshes"),
        ("lost", "lost: there is no such folder of meshes"),
        ("dead", "dead/cup.obj is a link to ../gone.obj, which does not exist"),
    ],
)
def test_a_folder_that_cannot_be_used_is_named(folder, path, line):
    for name in ("empty", "dead"):
        (folder / name).mkdir()
    (folder / "empty" / "notes.txt").touch()
    (folder / "lost").symlink_to("nothing")
    (folder / "dead" / "cup.obj").symlink_to("../gone.obj")
    assert problems(meshes(path)) == [f"datasets.m: {line.format(home=folder)}"]


@pytest.mark.usefixtures("folder")
def test_files_and_folders_that_may_not_be_read_are_named(monkeypatch):
    """Root may read everything, so the system is asked to refuse."""
    real_open, real_scan = Path.open, os.scandir

    def refuse(path, *arguments, **named):
        if path.name == "box.stl":
            raise PermissionError(13, "Permission denied", str(path))
        return real_open(path, *arguments, **named)

    monkeypatch.setattr(Path, "open", refuse)
    refused = "parts/box.stl cannot be read: Permission denied"
    assert problems(meshes("parts")) == [f"datasets.m: {refused}"]

    def closed(path="."):
        if Path(path).name == "parts":
            raise PermissionError(13, "Permission denied", str(path))
        return real_scan(path)

    monkeypatch.setattr(os, "scandir", closed)
    assert problems(meshes("parts")) == ["datasets.m: parts: cannot be read: Permission denied"]


def test_everything_that_is_missing_is_said_at_once(folder):
    two = {name: {"source": "meshes", "folder": name, "units": "mm"} for name in ("a", "b")}
    found = problems(
        {
            "datasets": two | {"c": {"source": "archive", "archive": "old/archive.parquet"}},
            "hole": {"kind": "mesh", "mesh": "hole.stl"},
            "measures": {"complexity": "~/mine.py:size"},
            "grippers": {"wide": {"opening": 0.1, "mesh": "palm.stl"}},
            "detectors": {"own": {"detector": "grasp.py:Own"}},
            "targets": {
                "datasets": [],
                "grippers": ["wide"],
                "detectors": ["own"],
                "exports": ["isaac_grasp"],
            },
            "graspability": {"gripper": "wide"},
        }
    )
    starts = [
        "datasets.a: a: there is no such folder of meshes",
        "datasets.b: b: there is no such folder of meshes",
        "datasets.c: old/archive.parquet does not exist",
        "hole.mesh: hole.stl does not exist",
        f"measures: {folder}/mine.py:size: there is no such file or module",
        "detectors: grasp.py:Own: there is no such file or module",
        "grippers.wide: palm.stl does not exist",
        "targets.exports: gripper 'wide' is made of boxes",
    ]
    assert len(found) == len(starts)
    for line, start in zip(found, starts, strict=True):
        assert line.startswith(start)


@pytest.mark.usefixtures("folder")
def test_nothing_is_asked_of_what_no_target_uses():
    unused = {
        "grippers": {"egad_75mm": {"opening": 0.075}, "lost": {"opening": 0.1, "mesh": "gone.stl"}},
        "graspability": {"gripper": "egad_75mm"},
        "detectors": {
            "antipodal-depth": {"detector": "antipodal-depth"},
            "lost": {"detector": "gone.py:Own"},
        },
    }
    assert problems(meshes("parts", **unused)) == []


@pytest.mark.usefixtures("folder")
def test_weights_that_a_workflow_makes_need_not_be_there_yet():
    def asked(weights):
        detector = {"detector": "vgn", "weights": weights}
        return meshes(
            "parts", detectors={"mine": detector}, targets={"datasets": [], "clutter": ["mine"]}
        )

    (line,) = problems(asked("lost.safetensors"))
    assert "lost.safetensors" in line
    assert problems(asked("results/made.safetensors")) == []


def test_a_long_list_of_files_is_cut(folder):
    with pytest.raises(UserError) as caught:
        check_readable([folder / f"{number}.stl" for number in range(100)])
    *lines, last = str(caught.value).split("\n")
    assert len(lines) == 10
    assert last == "and 90 more files cannot be read"
