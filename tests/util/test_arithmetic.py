"""What decides the last bits, told in one text."""

import threadpoolctl

from egad._util import arithmetic


def test_libraries_that_only_another_package_uses_are_left_out(monkeypatch):
    known = arithmetic.arithmetic.__wrapped__()
    other = {
        "user_api": "blas",
        "internal_api": "openblas",
        "architecture": "Prescott",
        "filepath": "/lib/python3/site-packages/opencv_python.libs/libopenblasp.so",
    }
    loaded = [*threadpoolctl.threadpool_info(), other]
    monkeypatch.setattr(arithmetic, "threadpool_info", lambda: loaded)
    assert arithmetic.arithmetic.__wrapped__() == known
    system = other | {"filepath": "/usr/lib/x86_64-linux-gnu/libopenblas.so.0"}
    monkeypatch.setattr(arithmetic, "threadpool_info", lambda: [*loaded, system])
    assert "Prescott" in arithmetic.arithmetic.__wrapped__()
