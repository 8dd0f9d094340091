"""Objects as mesh files, which hold their surface alone."""

from pathlib import Path

from egad.io import write_mesh
from egad.sim import SimulationObject


def write(folder: Path, name: str, made: SimulationObject, _friction: float, ending: str) -> None:
    """Write `NAME.ENDING`, with the arguments of formats of objects."""
    write_mesh(made.mesh, folder / f"{name}.{ending}")
