"""Mesh files written the same way every time; `egad.io` reads them."""

from pathlib import Path

import numpy as np
import trimesh

from egad._util.files import atomic_output
from egad.io import ENDINGS, obj_text, read_mesh

__all__ = ["ENDINGS", "read_mesh", "write_obj", "write_stl_mm"]


def write_obj(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a Wavefront OBJ file in the unit of the mesh, with enough digits to read it back."""
    text = obj_text(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="ascii")


def write_stl_mm(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a binary STL file in millimetres; its header says so."""
    facets = np.zeros(
        len(mesh.faces),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")],
    )
    facets["normal"] = mesh.face_normals
    facets["corners"] = mesh.triangles * 1000
    header = b"egad, unit: millimetre".ljust(80)
    with atomic_output(path) as temporary:
        temporary.write_bytes(header + np.uint32(len(facets)).tobytes() + facets.tobytes())
