import re
import shutil
import subprocess

import numpy as np
import pytest

from egad.evalset.printing import plan_prints
from egad.exchange.threemf import Placed, write_3mf
from egad.settings import PrintCheck, PrintExport

SLICER = shutil.which("prusa-slicer")
LIKE_OURS = ["--layer-height", "0.2", "--fill-density", "20%", "--perimeters", "2"]


def said(*arguments):
    result = subprocess.run(
        [SLICER, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=600
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.mark.slow
@pytest.mark.skipif(SLICER is None, reason="prusa-slicer is not installed")
@pytest.mark.parametrize("bed", [(0.22, 0.22), (0.256, 0.256)])
def test_a_real_slicer_finds_nothing_to_repair_and_slices_every_plate(released_set, bed, tmp_path):
    items = plan_prints(released_set, PrintExport(bed=bed), PrintCheck())
    assert all(item.plate for item in items.values()), "all can be printed"
    sides = [f"{1000 * side:g}" for side in bed]
    shape = f"0x0,{sides[0]}x0,{sides[0]}x{sides[1]},0x{sides[1]}"
    grams = 0.0
    for plate in sorted({item.plate for item in items.values()}):
        path = tmp_path / f"plate-{plate}.3mf"
        on_it = {label: item for label, item in items.items() if item.plate == plate}
        placed = {
            label: Placed(item.pose.mesh, np.array([*item.place, 0]))
            for label, item in on_it.items()
        }
        write_3mf(placed, path, {"Title": f"Plate {plate}"})
        info = said("--info", path)
        assert info.count("manifold = yes") == len(on_it)
        assert "repaired" not in info
        assert "open_edges" not in info
        code = tmp_path / f"plate-{plate}.gcode"
        said("-g", path, "--bed-shape", shape, "--dont-arrange", *LIKE_OURS, "-o", code)
        used = re.search(r"filament used \[cm3\] = ([\d.]+)", code.read_text())
        grams += 1.24 * float(used.group(1))
    estimated = 1000 * sum(item.filament for item in items.values())
    assert grams == pytest.approx(estimated, rel=0.15)
