"""Files after public bug reports, mostly of a box of 60 x 40 x 30 mm: read right, or refused."""

from pathlib import Path

import pytest

from egad.errors import RejectedError
from egad.geometry.repair import repair
from egad.io import read_mesh

FILES = Path(__file__).parents[1] / "data/meshes"
BOX, VOLUME = (60, 40, 30), 72_000
UPRIGHT_BOX = (60, 30, 40)  # y of the file is up
TWO = ((60, 40, 49.9), 79_960)
SOLIDS = {  # file: unit, size in mm, volume of the solid in mm3
    **{f"obj_relative/{name}_two.obj": ("mm", *TWO) for name in ("absolute", "relative")},
    "obj_relative/relative_one.obj": ("mm", BOX, VOLUME),
    "glb_quantised/quantised_i2_normalized.glb": (None, UPRIGHT_BOX, VOLUME),
    "glb_quantised/quantised_i2_plain.glb": (None, UPRIGHT_BOX, VOLUME),
    **{
        f"stl_variants/{path.name}": ("mm", BOX, VOLUME)
        for path in (FILES / "stl_variants").iterdir()
        if path.stem not in ("ascii_two_solids", "count_too_large")
    },
    "stl_variants/ascii_two_solids.stl": ("mm", *TWO),
    "3mf_units/inch.3mf": ("inch", BOX, VOLUME),
    "3mf_units/meter.3mf": ("m", BOX, VOLUME),
    "3mf_units/no_unit.3mf": ("mm", BOX, VOLUME),
    **{
        f"off_variants/{path.name}": ("mm", BOX, VOLUME)
        for path in (FILES / "off_variants").iterdir()
    },
    "glb_nodes/centimetres.glb": (None, (0.6, 0.4, 0.3), 0.072),
    "glb_nodes/nested.glb": (None, (120, 104.8, 80), 576_000),  # of the larger of two boxes
    "without_thickness/foil.stl": ("mm", (100, 60, 0.05), 300),
}
THICKEN = "open_surfaces: thicken"
REFUSED = {
    "stl_variants/count_too_large.stl": ("mm", "truncated"),
    "3mf_units/inch.3mf": ("mm", "inch, but mm"),
    "3mf_units/meter.3mf": ("mm", "m, but mm"),
    "without_thickness/cup_shell.stl": ("mm", THICKEN),
    "without_thickness/open_box.obj": ("mm", THICKEN),
    "without_thickness/open_box_both_sides.obj": ("mm", THICKEN),
    "without_thickness/sheet.stl": ("mm", THICKEN),
    "without_thickness/sheet_both_sides.stl": ("mm", THICKEN),
}


def test_every_file_is_known():
    found = {str(path.relative_to(FILES)) for path in FILES.rglob("*.*") if path.is_file()}
    assert found == {*SOLIDS, *REFUSED}


@pytest.mark.parametrize("name", SOLIDS)
def test_reported_files_give_their_solids(name):
    units, size, volume = SOLIDS[name]
    mesh = read_mesh(FILES / name, units)
    assert 1000 * mesh.extents == pytest.approx(size, rel=1e-4)
    assert 1e9 * repair(mesh).mesh.volume == pytest.approx(volume, rel=1e-3)
    if name.endswith(".3mf"):
        assert read_mesh(FILES / name, None).extents == pytest.approx(mesh.extents)


@pytest.mark.parametrize("name", REFUSED)
def test_reported_files_are_refused_with_their_reason(name):
    units, reason = REFUSED[name]
    with pytest.raises(RejectedError, match=reason):
        repair(read_mesh(FILES / name, units))
    if reason == THICKEN:
        assert repair(read_mesh(FILES / name, units), "thicken").mesh.is_watertight
