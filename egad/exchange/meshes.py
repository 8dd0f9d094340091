"""Mesh files of other programs: read with units and checked; written the same way every time."""

import io
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.files import atomic_output
from egad.errors import RejectedError, UserError
from egad.exchange.bounds import MOST_BYTES, MOST_ITEMS, within
from egad.exchange.folders import ENDINGS
from egad.exchange.promises import check_promises, only_geometry
from egad.exchange.promises_glb import only_positions
from egad.exchange.wavefront import obj_text, parse_plain_obj
from egad.geometry.checks import check_surface

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}


def read_mesh(path: Path, units: str) -> trimesh.Trimesh:
    """Read a mesh file as one mesh in metres, vertices at the same place merged.

    Args:
        path: A file with one of `egad.exchange.folders.ENDINGS`.
        units: Unit of its coordinates: m, cm, mm or inch.

    Raises:
        UserError: The unit is unknown.
        RejectedError: The file is not a mesh, is empty, or has coordinates that are not finite.
    """
    if units not in METRES:
        raise UserError(f"unit {units!r} is not known; allowed: {', '.join(METRES)}")
    vertices, faces = _load(path)
    mesh = trimesh.Trimesh(vertices * METRES[units], faces, process=False)
    check_surface(mesh)
    with np.errstate(invalid="ignore"):  # coordinates too large to round
        mesh.merge_vertices()
    return mesh


def _load(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices and faces. Readers raise whatever comes their way on broken files."""
    if not path.is_file():
        raise RejectedError("no such file")
    if path.suffix.lower() not in ENDINGS:
        raise RejectedError(f"not a mesh file; allowed endings: {' '.join(ENDINGS)}")
    unreadable = f"not a readable {path.suffix[1:]} file"
    within(path.stat().st_size, MOST_BYTES, "bytes")
    data, ending = path.read_bytes(), path.suffix[1:].lower()
    try:
        check_promises(data, ending)
        plain = parse_plain_obj(data) if ending == "obj" else None
        vertices, faces = plain or _load_any(data, ending)
        shared = ending != "stl"  # whose faces have three of their own
        within(len(vertices), MOST_ITEMS if shared else 3 * MOST_ITEMS, "vertices")
        within(len(faces), MOST_ITEMS, "faces")
    except RejectedError as reason:
        raise RejectedError(f"{unreadable}: {reason}") from reason
    except MemoryError:
        raise  # says nothing of the file
    except Exception as error:
        raise RejectedError(unreadable) from error
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise RejectedError(f"{unreadable}: faces name vertices that are not there")
    return vertices, faces


def _load_any(data: bytes, ending: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Read what is in the file, and nothing that it names."""
    bare = {"obj": only_geometry, "glb": only_positions}.get(ending, bytes)
    content = io.BytesIO(bare(data))
    options = {"process": False, "maintain_order": True, "skip_materials": True}
    with np.errstate(all="ignore"):
        found = trimesh.load_mesh(content, ending, **options)
    vertices = np.asarray(found.vertices, dtype=np.float64).reshape(-1, 3)
    return vertices, np.asarray(found.faces, dtype=np.int64).reshape(-1, 3)


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
