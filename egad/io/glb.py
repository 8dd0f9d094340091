"""Objects as GLB (binary glTF 2.0), for browsers and Blender: the surface with a material.

glTF is Y up. The z axis of the mesh points up in the file, so that a program that is Z up, such as
Blender, shows the object in the frame of its mesh.
"""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from egad._util.files import atomic_output
from egad.io.gltf import TO_Y_UP

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963  # numbers of OpenGL, which glTF uses
GREY_LINEAR = (0.48, 0.51, 0.57)  # linear RGB
ROUGHNESS = 0.7  # of a matte surface


def write_glb(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a GLB file, metres, matte gray with flat faces; its node has the name of the file."""
    material = trimesh.visual.material.PBRMaterial(
        name="grey",
        baseColorFactor=(*GREY_LINEAR, 1.0),
        metallicFactor=0.0,
        roughnessFactor=ROUGHNESS,
    )
    turned = trimesh.Trimesh(
        np.asarray(mesh.vertices) @ TO_Y_UP.T,
        mesh.faces,
        process=False,
        visual=trimesh.visual.TextureVisuals(material=material),
    )
    scene = trimesh.Scene()
    scene.add_geometry(turned, node_name=path.stem, geom_name=path.stem)
    data = scene.export(file_type="glb", tree_postprocessor=_name_targets)
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)


def _name_targets(document: dict[str, Any]) -> None:
    """Say which buffer views hold vertices and which indices, as glTF recommends."""
    (mesh,) = document["meshes"]
    (primitive,) = mesh["primitives"]
    for accessor, target in (
        (primitive["attributes"]["POSITION"], ARRAY_BUFFER),
        (primitive["indices"], ELEMENT_ARRAY_BUFFER),
    ):
        view = document["accessors"][accessor]["bufferView"]
        document["bufferViews"][view]["target"] = target
