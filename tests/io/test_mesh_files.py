"""Every file of `mesh_files.py` gives the right solid, or is refused with the right reason."""

import pytest
from mesh_files import CASES

from egad.errors import RejectedError
from egad.io import read_mesh

READ = [name for name, case in CASES.items() if not case.refusal]
REFUSED = [name for name, case in CASES.items() if case.refusal]


def read(folder, name):
    (folder / name).write_bytes(CASES[name].data)
    return read_mesh(folder / name, CASES[name].units)


@pytest.mark.parametrize("name", READ)
def test_files_give_the_solid_that_they_hold(tmp_path, name):
    case, mesh = CASES[name], read(tmp_path, name)
    rough = 0.01 if "int8" in name else 1e-4
    assert 1000 * mesh.extents == pytest.approx(case.size, rel=rough)
    if case.volume is not None:
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert 1e9 * mesh.volume == pytest.approx(case.volume, rel=3 * rough)


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_right_is_refused_by_name(tmp_path, name):
    with pytest.raises(RejectedError, match=CASES[name].refusal) as found:
        read(tmp_path, name)
    assert len(str(found.value)) < 200
