"""Mesh files of other programs: read with units and checked; written the same way every time."""

from pathlib import Path

import numpy as np
import trimesh

from egad._util.files import atomic_output
from egad._util.input_limits import MAX_DIRECT_BYTES, MAX_FACES, MAX_MESH_BYTES, check_at_most
from egad._util.limited import LimitError, limited
from egad.errors import RejectedError, UserError
from egad.exchange.mesh_parsers import Arrays, parse, parse_file
from egad.exchange.wavefront import obj_text, parse_plain_obj
from egad.geometry import check_surface

ENDINGS = (".3mf", ".glb", ".obj", ".off", ".ply", ".stl")
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}


def read_mesh(path: Path, units: str) -> trimesh.Trimesh:
    """Read a mesh file as one mesh in metres, vertices at the same place merged.

    Args:
        path: A file with one of `ENDINGS`.
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


def _load(path: Path) -> Arrays:
    """Vertices and faces. Parsers raise whatever comes their way on broken files."""
    if not path.is_file():
        raise RejectedError("no such file")
    if path.suffix.lower() not in ENDINGS:
        raise RejectedError(f"not a mesh file; allowed endings: {' '.join(ENDINGS)}")
    unreadable = f"not a readable {path.suffix[1:]} file"
    check_at_most(path.stat().st_size, MAX_MESH_BYTES, "bytes")
    try:
        vertices, faces = _parsed(path)
    except (RejectedError, LimitError) as reason:
        raise RejectedError(f"{unreadable}: {reason}") from reason
    except (MemoryError, UserError):
        raise  # says nothing of the file
    except Exception as error:
        raise RejectedError(unreadable) from error
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise RejectedError(f"{unreadable}: faces refer to vertices that do not exist")
    return vertices, faces


def _parsed(path: Path) -> Arrays:
    """Parse a file: here if its size says what that takes, else in a limited process."""
    ending = path.suffix[1:].lower()
    if ending == "obj":
        data = path.read_bytes()
        if plain := parse_plain_obj(data):
            return plain
        if len(data) <= MAX_DIRECT_BYTES:
            return parse(data, ending)
    elif ending == "stl" and _is_binary_stl(path):
        return parse_file(path)
    return limited(parse_file, path)


def _is_binary_stl(path: Path) -> bool:
    """Whether a file is as long as a header of binary STL says.

    Raises:
        RejectedError: It has more faces than are read.
    """
    with path.open("rb") as file:
        count = int.from_bytes(file.read(84)[80:], "little")
    if path.stat().st_size != 84 + 50 * count:
        return False
    check_at_most(count, MAX_FACES, "faces")
    return True


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
