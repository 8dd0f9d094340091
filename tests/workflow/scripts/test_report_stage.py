"""The report names what made it, whichever physics engine is installed."""

from importlib.metadata import PackageNotFoundError

import numpy
import pytest
import report


def test_packages_that_are_missing_have_no_version(monkeypatch: pytest.MonkeyPatch) -> None:
    found = report.version

    def without_pybullet(name: str) -> str:
        if name == "pybullet":
            raise PackageNotFoundError(name)
        return found(name)

    monkeypatch.setattr(report, "version", without_pybullet)
    versions = report.versions()
    assert "pybullet" not in versions
    assert versions["numpy"] == numpy.__version__
    assert set(report.PACKAGES) - set(versions) == {"pybullet"}
