import pytest
from bars import NONE, atlas, thick_only
from failure_searches import parts_kept

from egad.bench.failures import match_failures

ATTEMPTS = 5


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


@pytest.fixture(scope="session")
def matched(failing, parts_folder):
    """Both failures of it, with their partners."""
    with parts_kept(parts_folder):
        return match_failures(failing, thick_only, pairs=2, attempts=ATTEMPTS, objects=NONE)
