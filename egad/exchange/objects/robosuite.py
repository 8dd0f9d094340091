"""Objects as MJCF with the conventions of robosuite's `MujocoXMLObject`.

The body is named `object` and lies in a body without a name; robosuite adds the free joint. Geoms
of group 0 collide and those of group 1 are drawn. Three sites tell robosuite how large it is.
"""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import trimesh

from egad.exchange.object_files import (
    MeshFiles,
    number_text,
    write_object_meshes,
    write_poses,
    xml_document,
)
from egad.exchange.objects.mjcf import GeomGroups, add_solid, mjcf_model
from egad.sim import SimulationObject

GROUPS = GeomGroups(visual="1", collision="0")
SITE_RADIUS = 0.005  # metres; robosuite reads positions only


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `NAME.xml`, its meshes and `poses.json`."""
    files = write_object_meshes(folder / name, made)
    text = _text(name, files, made, friction)
    (folder / name / f"{name}.xml").write_text(text, encoding="utf-8")
    write_poses(folder / name, made)


def _text(name: str, files: MeshFiles, made: SimulationObject, friction: float) -> str:
    model, assets, world = mjcf_model(name)
    wrapper = ElementTree.SubElement(world, "body")
    body = ElementTree.SubElement(wrapper, "body", name="object")
    add_solid(assets, body, name, files, made, friction, GROUPS)
    for site, position in _sites(made.mesh).items():
        attributes = {"name": site, "pos": number_text(*position), "rgba": "0 0 0 0"}
        ElementTree.SubElement(wrapper, "site", attributes, size=number_text(SITE_RADIUS))
    return xml_document(model)


def _sites(mesh: trimesh.Trimesh) -> dict[str, tuple[float, float, float]]:
    """Positions of the sites: the lowest and highest point, and the radius about the z axis."""
    low, high = np.asarray(mesh.bounds)[:, 2]
    radius = float(np.linalg.norm(np.asarray(mesh.vertices)[:, :2], axis=1).max())
    return {
        "bottom_site": (0.0, 0.0, float(low)),
        "top_site": (0.0, 0.0, float(high)),
        "horizontal_radius_site": (radius, radius, 0.0),
    }
