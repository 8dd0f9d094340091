import numpy as np
import pytest
from threadpoolctl import threadpool_info

from egad.workers import workers


def threads_for_algebra(matrix):
    assert np.linalg.det(matrix) == 1
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_results_are_in_order():
    with workers(2) as mapper:
        assert list(mapper(abs, range(-9, 0))) == list(range(9, 0, -1))


@pytest.mark.parametrize("count", [1, 2])
def test_a_worker_has_one_thread_for_algebra(count):
    with workers(count) as mapper:
        found = list(mapper(threads_for_algebra, [np.eye(3)] * 4))
    assert all(found)
    assert all(count == 1 for counts in found for count in counts)
