import shutil

import pandas as pd
import pytest
from noted_stage import stage

from egad.errors import UserError
from egad.io.sums import SUMS, write_sums
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad_workflow.verify import verify


def problems(folder):
    found = verify(folder).problems
    return {path.relative_to(folder).as_posix(): problem for path, problem in found.items()}


def test_what_was_made_is_as_it_was_made(made):
    verdict = verify(made)
    assert (verdict.problems, verdict.unknown, verdict.gone) == ({}, [], 0)
    assert verdict.checked == 9


@pytest.mark.parametrize(
    "name", ["objects.parquet", "comparison.parquet", "meshes/b.obj", "map.svg"]
)
def test_an_altered_file_is_named(made, name):
    data = bytearray((made / name).read_bytes())
    data[len(data) // 2] ^= 1
    (made / name).write_bytes(data)
    assert problems(made)[name] == "altered"


def test_an_altered_table_that_was_written_anew_is_named(made):
    frame = parquet.read(made / "objects.parquet", REJECTED)
    frame.assign(reason="another").to_parquet(made / "objects.parquet")
    assert "no provenance recorded" in problems(made)["objects.parquet"]


def test_what_was_made_from_an_altered_table_that_is_sealed_again_is_named(made):
    row = {"id": "x", "stage": "", "reason": ""}
    parquet.write(pd.DataFrame([row]), REJECTED, made / "objects.parquet")
    problem = f"made from a different version of {made}/objects.parquet"
    assert problems(made) == {"comparison.parquet": problem, "map.svg": problem}


def test_sums_that_were_made_to_fit_are_named_too(made):
    (made / "meshes/a.obj").write_text("altered")
    write_sums(made / "meshes")
    assert problems(made)["comparison.parquet"].startswith(
        f"made from a different version of {made}/meshes"
    )


def test_deleted_and_added_meshes_are_named(made):
    (made / "meshes/a.obj").rename(made / "meshes/c.obj")
    found = problems(made)
    assert found["meshes/a.obj"] == "deleted"
    assert found["meshes/c.obj"].startswith("added")


def test_damaged_sums_are_named(made):
    (made / f"meshes/{SUMS}").write_text("nonsense")
    assert problems(made)[f"meshes/{SUMS}"].startswith("altered")


def test_parts_may_be_deleted_and_files_of_others_lie_beside(made):
    shutil.rmtree(made / "parts")
    (made / "notes.txt").write_text("mine")
    verdict = verify(made)
    assert (verdict.problems, verdict.gone) == ({}, 3)
    assert verdict.unknown == [made / "notes.txt"]


def test_what_lies_in_linked_folders_is_checked(made, tmp_path):
    """Also what was made from it: wherever the link leads."""
    (made / "meshes").rename(tmp_path / "elsewhere")
    (made / "meshes").symlink_to(tmp_path / "elsewhere")
    (made / "round").symlink_to(".")
    verdict = verify(made)
    assert (verdict.problems, verdict.unknown, verdict.gone) == ({}, [], 0)
    assert verdict.checked == 9
    (tmp_path / "elsewhere/a.obj").write_text("altered")
    assert problems(made) == {"meshes/a.obj": "altered"}
    write_sums(made / "meshes")
    assert problems(made)["comparison.parquet"].startswith("made from a different version")


def test_there_must_be_something_to_compare(tmp_path):
    with pytest.raises(UserError, match="no provenance recorded"):
        verify(tmp_path)
    with pytest.raises(UserError, match="no such folder"):
        verify(tmp_path / "gone")


def test_what_a_stranger_names_is_not_read(stranger):
    verdict = verify(stranger)
    assert (verdict.problems, verdict.gone) == ({}, 1)


@pytest.mark.parametrize(
    "name", ["/dev/zero", "../../secret", "a/../../../secret", "/etc/hostname"]
)
@pytest.mark.usefixtures("soon")
def test_sums_are_about_their_folder(made, name):
    with (made / f"meshes/{SUMS}").open("a") as file:
        file.write(f"00  {name}\n")
    assert problems(made)[f"meshes/{SUMS}"] == "altered: not a checksum file"


def test_inputs_in_the_working_directory_are_compared(made, tmp_path):
    (tmp_path / "scan.obj").write_text("scan")
    with stage("compare", None, [tmp_path / "scan.obj"], [made / "map.svg"]):
        pass
    assert not problems(made)
    (tmp_path / "scan.obj").write_text("another")
    assert "made from a different version" in problems(made)["map.svg"]
