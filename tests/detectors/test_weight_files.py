import zipfile

import pytest

from egad.detectors.ggcnn import check_ggcnn
from egad.errors import UserError


@pytest.mark.parametrize("size", [1 << 20, 1 << 25])
def test_weights_are_not_larger_unpacked(tmp_path, size):
    path = tmp_path / "weights.pt"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data/0", bytes(size))
    assert path.stat().st_size < 100_000
    if size < 1 << 24:
        assert check_ggcnn(str(path)) == str(path)
        return
    with pytest.raises(UserError, match="too large"):
        check_ggcnn(str(path))


def test_a_damaged_zip_is_left_to_its_reader(tmp_path):
    path = tmp_path / "weights.pt"
    path.write_bytes(b"PK\x01\x02" + bytes(100) + b"PK\x05\x06" + b"\xff" * 18)
    assert check_ggcnn(str(path)) == str(path)
