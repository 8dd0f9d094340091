import pytest
from bars import NONE, atlas, thick_only

from egad.failures import match_failures

ATTEMPTS = 5


@pytest.fixture(scope="session")
def failing():
    """An atlas of bars: the detector misses those that are thin."""
    return atlas()


@pytest.fixture(scope="session")
def matched(failing):
    """Both failures of it, with their partners."""
    return match_failures(failing, thick_only, pairs=2, attempts=ATTEMPTS, objects=NONE)
