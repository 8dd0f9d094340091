"""Objects as URDF files side by side in one folder, which the simulator of VGN takes."""

from pathlib import Path

from egad.exchange.object_files import write_object_meshes
from egad.exchange.objects.urdf import urdf_text
from egad.sim import SimulationObject


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write `NAME.urdf`, and its meshes into the folder `NAME`."""
    files = write_object_meshes(folder / name, made).within(name)
    text = urdf_text(name, files, made.physics, friction)
    (folder / f"{name}.urdf").write_text(text, encoding="utf-8")
