"""`egad genome` and `egad export-meshes --resolution`."""

import pytest
import trimesh
from commands import egad as command

import egad
from egad.data import released


def test_a_genome_is_printed_and_drawn(tmp_path):
    each = egad.load("released")["M14_3"]
    assert command("genome", "M14_3").stdout == egad.genome_text(each.genome)
    drawn = command("genome", each.id, "--in", released(), "--out", tmp_path / "drawn.svg")
    assert drawn.returncode == 0
    assert drawn.stdout == egad.genome_text(each.genome)
    assert (tmp_path / "drawn.svg").read_text(encoding="utf-8") == egad.genome_svg(each.genome)


def test_an_ancestor_has_a_genome_too():
    objects = egad.load("released")
    line = objects.lineage.line(objects["M14_3"].id)
    ancestor = next(each for each in line if each not in objects)
    expected = egad.genome_text(objects.lineage.genome(ancestor))
    assert command("genome", ancestor).stdout == expected


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["genome", "M14_33"], "did you mean"),
        (["genome", "M14_3", "--out", "drawn.png"], "must end in .svg"),
        (["export-meshes", "released", "--out", "new", "--resolution", "500"], "equal to 200"),
        (["export-meshes", "released", "--out", "new", "--object", "M1"], "is not known"),
        (["export-meshes", "config", "--out", "new"], "its objects come from meshes"),
    ],
)
def test_what_there_is_not_is_a_sentence(arguments, sentence):
    result = command(*arguments)
    assert result.returncode in (1, 2)
    assert sentence in result.stderr
    assert "Traceback" not in result.stderr


def test_meshes_at_another_resolution(tmp_path):
    each = egad.load("released")["M14_3"]
    for resolution in (25, 40):
        where = ["--out", tmp_path / str(resolution), "--resolution", resolution]
        assert command("export-meshes", "released", *where, "--object", "M14_3").returncode == 0
    command("export-meshes", "released", "--out", tmp_path / "own", "--object", each.id)
    name = f"{each.id}.obj"
    assert (tmp_path / "25" / name).read_bytes() == (tmp_path / "own" / name).read_bytes()
    assert [path.name for path in (tmp_path / "40").iterdir()] == [name]
    fine = trimesh.load(tmp_path / "40" / name)
    assert fine.is_watertight
    assert fine.volume == pytest.approx(egad.genome_mesh(each.genome, 40).volume, rel=1e-5)
