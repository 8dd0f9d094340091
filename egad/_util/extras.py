"""Packages that are installed on request only: `pip install 'egad[sim]'`."""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from egad.errors import MissingPackageError


class Package(NamedTuple):
    """A package of an extra."""

    name: str  # its official name
    extra: str  # the extra of egad that installs it


# By import name; the versions are in pyproject.toml.
PACKAGES = {
    "coacd": Package("CoACD", "coacd"),
    "collada": Package("pycollada", "sim"),
    "h5py": Package("h5py", "sim"),
    "igl": Package("libigl", "sim"),
    "imageio": Package("imageio", "sim"),
    "matplotlib": Package("Matplotlib", "plot"),
    "msgpack": Package("msgpack", "sim"),
    "mujoco": Package("MuJoCo", "sim"),
    "pxr": Package("OpenUSD", "usd"),
    "pybullet": Package("PyBullet", "sim"),
    "pydrake": Package("Drake", "drake"),
    "safetensors": Package("safetensors", "vision"),
    "snakemake": Package("Snakemake", "workflow"),
    "torch": Package("PyTorch", "vision"),
    "zmq": Package("PyZMQ", "graspgen"),
}


@contextmanager
def needed_for(what: str) -> Iterator[None]:
    """Import packages of an extra, which `MissingPackageError` names, for what the user wants."""
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if isinstance(error, MissingPackageError) or module not in PACKAGES:
            raise
        raise _missing(what, module) from error


def check_installed(module: str, what: str) -> None:
    """Raise `MissingPackageError` if a package of an extra is missing, without importing it."""
    if importlib.util.find_spec(module) is None:
        raise _missing(what, module)


def _missing(what: str, module: str) -> MissingPackageError:
    name, extra = PACKAGES[module]
    return MissingPackageError(f"{what} needs {name}: pip install 'egad[{extra}]'", name=module)
