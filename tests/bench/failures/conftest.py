import pytest
from bars import atlas
from failure_searches import parts_kept


@pytest.fixture(scope="session")
def parts_folder(tmp_path_factory):
    """The folder of convex parts that were made once."""
    return tmp_path_factory.mktemp("parts")


@pytest.fixture(autouse=True, scope="module")
def _parts_kept(parts_folder):
    with parts_kept(parts_folder):
        yield


@pytest.fixture(scope="session")
def failing(parts_folder):
    """An atlas of bars: the detector misses those that are thin."""
    with parts_kept(parts_folder):
        return atlas()
