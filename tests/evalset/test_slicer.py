"""Plates of the released evaluation set in a real slicer: `make slicer`."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from egad.evalset import PrintCheck, PrintExport
from egad.evalset.plate_files import PlacedMesh, write_3mf
from egad.evalset.plates import pack, plan_prints

SLICER = shutil.which("prusa-slicer")
pytestmark = [
    pytest.mark.slicer,
    pytest.mark.skipif(SLICER is None, reason="prusa-slicer is not installed"),
]
BED, LARGER_BED = 0.22, 0.256
LIKE_OURS = ["--layer-height", "0.2", "--fill-density", "20%", "--perimeters", "2"]


@pytest.fixture(scope="module")
def items(released_set):
    """The set, planned for a bed of 220 mm."""
    return plan_prints(released_set, PrintExport(bed=(BED, BED)), PrintCheck())


def said(*arguments):
    result = subprocess.run(
        [SLICER, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=600
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def write_plates(meshes, places, folder):
    """Write the plates of objects; all of them are whole for the slicer too."""
    plates = {}
    for plate in sorted({place[0] for place in places.values()}):
        on_it = {label: place[1:] for label, place in places.items() if place[0] == plate}
        placed = {
            label: PlacedMesh(meshes[label], np.array([*where, 0]))
            for label, where in on_it.items()
        }
        plates[plate] = folder / f"plate-{plate}.3mf"
        write_3mf(placed, plates[plate], {"Title": f"Plate {plate}"})
        info = said("--info", plates[plate])
        assert info.count("manifold = yes") == len(on_it)
        assert "repaired" not in info
        assert "open_edges" not in info
    return plates


def filament(plate, side):
    """Slice a plate for a square bed: what it takes, grams."""
    code, end = plate.with_suffix(".gcode"), 1000 * side
    shape = f"0x0,{end:g}x0,{end:g}x{end:g},0x{end:g}"
    said("-g", plate, "--bed-shape", shape, "--dont-arrange", *LIKE_OURS, "-o", code)
    used = re.search(r"filament used \[cm3\] = ([\d.]+)", code.read_text())
    return 1.24 * float(used.group(1))


@pytest.fixture(scope="module")
def plates(items, tmp_path_factory):
    """Files of the plates of a bed of 220 mm by their numbers."""
    assert all(item.plate for item in items.values()), "all can be printed"
    meshes = {label: item.pose.mesh for label, item in items.items()}
    places = {label: (item.plate, *item.place) for label, item in items.items()}
    return write_plates(meshes, places, tmp_path_factory.mktemp("plates"))


def test_a_plate_that_needs_no_repair_takes_the_filament_of_its_objects(items, plates):
    estimated = 1000 * sum(item.filament for item in items.values() if item.plate == 1)
    assert filament(plates[1], BED) == pytest.approx(estimated, rel=0.06)


@pytest.mark.slow
def test_every_plate_can_be_sliced(items, plates):
    grams = sum(filament(plate, BED) for plate in plates.values())
    estimated = 1000 * sum(item.filament for item in items.values())
    assert grams == pytest.approx(estimated, rel=0.06)


@pytest.fixture(scope="module")
def larger(items, tmp_path_factory):
    """Places on a bed of 256 mm, where objects lie as on a smaller one, and files of its plates."""
    meshes = {label: item.pose.mesh for label, item in items.items()}
    sizes = {label: tuple(mesh.extents[:2]) for label, mesh in meshes.items()}
    places = pack(sizes, (LARGER_BED, LARGER_BED), PrintExport().gap)
    return places, write_plates(meshes, places, tmp_path_factory.mktemp("larger"))


def test_plates_of_a_larger_bed_are_whole_too(items, larger):
    places, _ = larger
    assert set(places) == set(items)
