import warnings
from contextlib import nullcontext

import pytest
import trimesh

import egad
from egad.errors import RejectedError, UserError
from egad.evalset.plate_files import PlacedMesh, write_3mf
from egad.io import check_unit_known, read_content, write_glb, write_stl_mm
from egad.io.units import metres_per_unit, stated_in

BOX = trimesh.creation.box((0.06, 0.04, 0.03))
LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        (b"egad, unit: millimetre", "mm"),
        (b"# File units = Inches", "inch"),
        (b"units: feet", "foot"),
        (b"unit: m4 bolt", None),
        (b"# units:\n# mm", None),
        (b"unit: mm, made by hand", "mm"),
        (b"# unit: dm", "dm"),
        (b"units in mm", "mm"),
        (b"# All units are in inches.", "inch"),
        (b"unit = m/s", None),
        ("unit: mm²".encode(), None),
        (b"unit: gearbox\n unit: cm", "cm"),
        (b"", None),
    ],
)
def test_units_that_comments_state(text, unit):
    assert stated_in(text) == unit


@pytest.mark.parametrize(
    ("asked", "stated", "ending", "length"),
    [
        ("inch", None, "glb", 0.0254),
        ("cm", "cm", "glb", 0.01),
        (None, "foot", "3mf", 0.3048),
        (None, "micron", "stl", 1e-6),
        (None, None, "glb", 1.0),
        (None, None, "3mf", 0.001),
    ],
)
def test_a_unit_is_what_is_asked_for_or_stated_or_that_of_the_format(asked, stated, ending, length):
    assert metres_per_unit(asked, stated, ending) == length


@pytest.mark.parametrize(
    ("asked", "stated", "words"),
    [("mm", "yard", "states the unit yard, but mm is given"), (None, None, "m, cm, mm or inch")],
)
def test_no_unit_and_two_units_are_refused(asked, stated, words):
    with pytest.raises(RejectedError, match=words):
        metres_per_unit(asked, stated, "stl")


def test_settings_need_a_unit_unless_all_files_state_it(tmp_path):
    given = [tmp_path / "a.3mf", tmp_path / "b.GLB"]
    check_unit_known(given, None)
    check_unit_known([*given, tmp_path / "c.stl"], "mm")
    BOX.export(tmp_path / "c.stl")
    write_stl_mm(BOX, tmp_path / "d.stl")
    (tmp_path / "e.obj").write_text("# units: inch\n")
    check_unit_known([*given, tmp_path / "d.stl", tmp_path / "e.obj"], None)
    with pytest.raises(UserError, match=r"c\.stl does not state its unit; .*: m, cm, mm or inch"):
        check_unit_known([*given, tmp_path / "c.stl"], None)


SOLIDS = {
    "obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    "off": "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
}


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("ending", SOLIDS)
@pytest.mark.parametrize(
    ("line", "unit"), [("# unit: mm", "mm"), ("#unit=cm #", "cm"), ("# comment", None)]
)
def test_what_states_the_unit_of_a_file_is_the_same_for_settings(tmp_path, ending, line, unit, end):
    path = tmp_path / f"a.{ending}"
    path.write_bytes(f"{line}\n{SOLIDS[ending]}".replace("\n", end).encode())
    assert read_content(path).unit == unit
    told = pytest.raises(UserError, match="does not state") if unit is None else nullcontext()
    with told:
        check_unit_known([path], None)


def read_quietly(path, units=None):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return egad.read_mesh(path, units)


def test_what_egad_writes_needs_no_unit(tmp_path):
    write_stl_mm(BOX, tmp_path / "box.stl")
    write_glb(BOX, tmp_path / "box.glb")
    write_3mf({"box": PlacedMesh(BOX, BOX.bounds[1])}, tmp_path / "box.3mf", {})
    for ending in ("stl", "glb", "3mf"):
        mesh = read_quietly(str(tmp_path / f"box.{ending}"))
        assert mesh.extents == pytest.approx(BOX.extents, rel=1e-6)
        assert mesh.volume == pytest.approx(BOX.volume, rel=1e-6)
    with pytest.raises(RejectedError, match="states the unit mm, but m is given"):
        egad.read_mesh(tmp_path / "box.stl", "m")


@pytest.mark.parametrize(
    ("true", "taken"),
    [("m", "m"), ("mm", "cm"), ("cm", "inch"), ("m", "mm"), ("mm", "m"), ("inch", "mm")],
)
def test_a_wrong_unit_of_a_box_of_60_mm_gives_a_warning(tmp_path, true, taken):
    BOX.copy().apply_scale(1 / LENGTHS[true]).export(tmp_path / "box.obj")
    usual = "cm" in (true, taken) and "m" not in (true, taken)  # 6 to 600 mm
    if true == taken or usual:
        read_quietly(tmp_path / "box.obj", taken)
        return
    side = 0.06 * LENGTHS[taken] / LENGTHS[true]
    with pytest.warns(egad.UnitsWarning, match=rf"of the mesh box\.obj is {side:.3g} m") as found:
        egad.read_mesh(tmp_path / "box.obj", taken)
    assert f"really in {taken}?" in str(found[0].message)
    assert found[0].filename == __file__


def test_no_unit_and_no_path_are_told(tmp_path):
    BOX.export(tmp_path / "box.ply")
    with pytest.raises(
        RejectedError, match="does not state its unit; give `units`: m, cm, mm or inch"
    ):
        egad.read_mesh(tmp_path / "box.ply")
    with pytest.raises(UserError, match="path"):
        egad.read_mesh(3, "mm")
