"""The formats that objects can be written in, and what writes one object of each."""

from collections.abc import Callable
from pathlib import Path

import trimesh

from egad._util import extras
from egad.evalset import SimulationObject
from egad.exchange.glb import write_glb
from egad.exchange.meshes import write_obj, write_stl_mm
from egad.exchange.mjcf import write_mjcf
from egad.exchange.robosuite import write_robosuite
from egad.exchange.sdf import write_sdf
from egad.exchange.simulators import write_simulation_object
from egad.exchange.urdf import write_urdf, write_vgn

# Each takes a folder, the name of the object, and the object.
MeshWriter = Callable[[Path, str, trimesh.Trimesh], None]
PhysicsWriter = Callable[[Path, str, SimulationObject, float], None]  # and its friction


def _write_obj(folder: Path, name: str, mesh: trimesh.Trimesh) -> None:
    write_obj(mesh, folder / f"{name}.obj")


def _write_stl(folder: Path, name: str, mesh: trimesh.Trimesh) -> None:
    write_stl_mm(mesh, folder / f"{name}.stl")


def _write_usd(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    from egad.exchange.usd import write_usd  # noqa: PLC0415 (it needs an extra)

    write_usd(folder, name, made, friction)


def _write_simulation(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    write_simulation_object(folder / name, name, made, friction)


MESH_WRITERS: dict[str, MeshWriter] = {
    "glb": write_glb,
    "obj": _write_obj,
    "stl": _write_stl,
}
PHYSICS_WRITERS: dict[str, PhysicsWriter] = {
    "mjcf": write_mjcf,
    "robosuite": write_robosuite,
    "sdf": write_sdf,
    "simulation": _write_simulation,
    "urdf": write_urdf,
    "usd": _write_usd,
    "vgn": write_vgn,
}
PACKAGES = {"usd": "pxr"}  # of an extra, by the format that needs it


def check_installed(name: str) -> None:
    """Check that the packages that a format needs are installed.

    Args:
        name: Of the format.

    Raises:
        UserError: One is missing.
    """
    if name in PACKAGES:
        extras.check_installed(PACKAGES[name], f"format {name}")
