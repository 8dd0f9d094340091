"""Mesh files: read with units and checked, and written in metres."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import trimesh

from egad._util.input_limits import MAX_DIRECT_BYTES, MAX_FACES, MAX_MESH_BYTES, check_at_most
from egad._util.limited import LimitError, limited
from egad._util.memory import is_out_of_memory
from egad.errors import RejectedError, UserError
from egad.geometry import check_surface
from egad.io.gltf import parse_glb, write_glb
from egad.io.obj import parse_obj, parse_plain_obj, write_obj
from egad.io.off import parse_off
from egad.io.ply import parse_ply
from egad.io.polygons import Content
from egad.io.stl import count_binary_faces, parse_stl, stated_in_header, write_stl_mm
from egad.io.threemf import parse_3mf
from egad.io.units import (
    ALLOWED,
    COMMENTS,
    PRESCRIBED,
    check_unit,
    metres_per_unit,
    stated_in_comments,
)

PARSERS: dict[str, Callable[[bytes], Content]] = {
    ".3mf": parse_3mf,
    ".glb": parse_glb,
    ".obj": parse_obj,
    ".off": parse_off,
    ".ply": parse_ply,
    ".stl": parse_stl,
}
ENDINGS = tuple(PARSERS)
WRITERS: dict[str, Callable[[trimesh.Trimesh, Path], None]] = {
    ".glb": write_glb,
    ".obj": write_obj,
    ".stl": write_stl_mm,
}


def read_mesh(path: Path, units: str | None) -> trimesh.Trimesh:
    """Read a file as `egad.read_mesh` does, without a warning of its unit."""
    check_unit(units)
    content = read_content(path)
    scale = metres_per_unit(units, content.unit, path.suffix[1:].lower())
    mesh = trimesh.Trimesh(content.vertices * scale, content.faces, process=False)
    check_surface(mesh)
    with np.errstate(invalid="ignore"):  # coordinates too large to round
        mesh.merge_vertices()
    check_surface(mesh)  # nothing may be left of tiny triangles
    return mesh


def write_mesh(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a mesh in metres, always with the same bytes; `UserError` for another ending."""
    ending = path.suffix.lower()
    if ending not in WRITERS:
        raise UserError(
            f"{path.name}: cannot write such files; allowed endings: {' '.join(WRITERS)}"
        )
    WRITERS[ending](mesh, path)


def read_content(path: Path) -> Content:
    """Vertices and faces of a mesh file, in its own unit, with z up, or `RejectedError`."""
    if not path.is_file():
        raise RejectedError("no such file")
    if path.suffix.lower() not in ENDINGS:
        raise RejectedError(f"not a mesh file; allowed endings: {' '.join(ENDINGS)}")
    unreadable = f"not a readable {path.suffix[1:]} file"
    check_at_most(path.stat().st_size, MAX_MESH_BYTES, "bytes")
    try:
        content = _parsed(path)
    except (RejectedError, LimitError) as reason:
        raise RejectedError(f"{unreadable}: {reason}") from reason
    except Exception as error:  # parsers may raise anything on broken files
        if isinstance(error, UserError) or is_out_of_memory(error):
            raise  # says nothing about the file
        raise RejectedError(f"{unreadable}: it is damaged") from error
    kept = np.asarray(np.isfinite(content.vertices).all(axis=1))
    if kept.all():
        return content
    kept[content.faces] = True
    faces = (np.cumsum(kept) - 1)[content.faces]
    return content._replace(vertices=content.vertices[kept], faces=faces)


def check_unit_known(paths: Iterable[Path], units: str | None) -> None:
    """Raise `UserError` if no unit is given and a file, which it names, states none."""
    for path in paths if units is None else ():
        ending = path.suffix.lower()
        if ending not in ENDINGS or ending[1:] in PRESCRIBED or not path.is_file():
            continue
        with path.open("rb") as file:
            start = file.read(COMMENTS)
        stated = stated_in_header if ending == ".stl" else stated_in_comments
        if stated(start) is None:
            raise UserError(
                f"{path.name} does not state its unit; "
                f"give `units` (--units of a command): {ALLOWED}"
            )


def _parsed(path: Path) -> Content:
    """Parse a file: here if its size limits the cost, otherwise in a limited process."""
    if path.suffix.lower() == ".obj":
        data = path.read_bytes()
        if plain := parse_plain_obj(data):
            return Content(*plain)
        if len(data) <= MAX_DIRECT_BYTES:
            return parse_obj(data)
    elif path.suffix.lower() == ".stl" and (count := count_binary_faces(path)) is not None:
        check_at_most(count, MAX_FACES, "faces")
        return parse_file(path)
    return limited(parse_file, path)


def parse_file(path: Path) -> Content:
    """What a mesh file holds. One that is damaged may raise anything, or take any memory."""
    return PARSERS[path.suffix.lower()](path.read_bytes())
