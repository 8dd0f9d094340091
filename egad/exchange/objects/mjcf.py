"""Objects as MJCF, for MuJoCo: one free body with the frame of the mesh.

A file has no `compiler` and no `default`, which would also apply to the rest of a scene that
includes it. It states what the defaults of that scene could change, except `material` and `fromto`,
which have no neutral value that all readers know.
"""

from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from egad.exchange.object_files import (
    GREY,
    MeshFiles,
    moments,
    number_text,
    write_object_meshes,
    write_poses,
    xml_document,
)
from egad.friction import MJCF_SPIN
from egad.sim import SimulationObject


class GeomGroups(NamedTuple):
    """The groups of geoms, as numbers in text."""

    visual: str
    collision: str


USUAL = GeomGroups("2", "3")  # MuJoCo does not draw group 3
# The defaults of MuJoCo
MESH = {"scale": "1 1 1", "maxhullvert": "-1"}
GEOM = {
    "type": "mesh",
    "pos": "0 0 0",
    "quat": "1 0 0 0",
    "condim": "3",
    "priority": "0",
    "margin": "0",
    "gap": "0",
    "solmix": "1",
    "solref": "0.02 1",
    "solimp": "0.9 0.95 0.001 0.5 2",
    "fluidshape": "none",
    "shellinertia": "false",
}


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `NAME.xml`, its meshes and `poses.json`."""
    files = write_object_meshes(folder / name, made)
    text = mjcf_text(name, files, made, friction)
    (folder / name / f"{name}.xml").write_text(text, encoding="utf-8")
    write_poses(folder / name, made)


def mjcf_text(name: str, files: MeshFiles, made: SimulationObject, friction: float) -> str:
    """The description of one object, whose only body has its name; mesh files are in metres."""
    model, assets, world = mjcf_model(name)
    body = ElementTree.SubElement(world, "body", name=name)
    ElementTree.SubElement(body, "freejoint")
    add_solid(assets, body, name, files, made, friction, USUAL)
    return xml_document(model)


def mjcf_model(name: str) -> tuple[ElementTree.Element, ElementTree.Element, ElementTree.Element]:
    """A model with no bodies: its root, its assets and its world."""
    model = ElementTree.Element("mujoco", model=name)
    assets = ElementTree.SubElement(model, "asset")
    return model, assets, ElementTree.SubElement(model, "worldbody")


def add_solid(
    assets: ElementTree.Element,
    body: ElementTree.Element,
    name: str,
    files: MeshFiles,
    made: SimulationObject,
    friction: float,
    groups: GeomGroups,
) -> None:
    """Give a body its inertia, visual mesh and convex parts; names of meshes begin with `name`."""
    physics = made.physics
    inertial = ElementTree.SubElement(body, "inertial", pos=number_text(*physics.com))
    inertial.set("mass", number_text(physics.mass))
    inertial.set("fullinertia", number_text(*moments(physics).values()))
    # The visual has the mass too, for scenes with inertiafromgeom="true". MuJoCo refuses the exact
    # inertia of a surface that touches itself along an edge.
    edges = np.asarray(made.mesh.edges)
    kind = "exact" if len(np.unique(edges, axis=0)) == len(edges) else "legacy"
    look = {"contype": "0", "conaffinity": "0", "group": groups.visual}
    look |= {"mass": number_text(physics.mass), "rgba": number_text(*GREY, 1)}
    _geom(assets, body, f"{name}-visual", files.visual, kind, look)
    sticks = {"contype": "1", "conaffinity": "1", "group": groups.collision, "mass": "0"}
    sticks |= {"friction": number_text(friction, *MJCF_SPIN), "rgba": "0.5 0.5 0.5 1"}
    for part in files.parts:
        # As a shell, a mesh may be arbitrarily thin; its inertia is not used.
        _geom(assets, body, f"{name}-{Path(part).stem}", part, "shell", sticks)


def _geom(
    assets: ElementTree.Element,
    body: ElementTree.Element,
    name: str,
    file: str,
    inertia: str,
    attributes: dict[str, str],
) -> None:
    ElementTree.SubElement(assets, "mesh", MESH, name=name, file=file, inertia=inertia)
    ElementTree.SubElement(body, "geom", {"mesh": name, **attributes, **GEOM})
