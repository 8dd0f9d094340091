"""3MF plates for printers: named objects at positions, in millimetres (core specification)."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.files import atomic_output
from egad.io.threemf import CORE

MILLIMETRES = 1000.0  # in a metre
_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can hold: same input, same bytes


@dataclass(frozen=True)
class PlacedMesh:
    """A mesh in metres, and where its origin lies on the plate, (3,) metres."""

    mesh: trimesh.Trimesh
    place: NDArray[np.float64]


def write_3mf(objects: Mapping[str, PlacedMesh], path: Path, metadata: Mapping[str, str]) -> None:
    """Write objects by name on a plate, in millimetres, with metadata of the core specification."""
    parts = {
        "[Content_Types].xml": _TYPES,
        "_rels/.rels": _RELATIONS,
        "3D/3dmodel.model": model_xml(objects, metadata),
    }
    with atomic_output(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, text in parts.items():
            entry = zipfile.ZipInfo(name, date_time=_EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)


def model_xml(objects: Mapping[str, PlacedMesh], metadata: Mapping[str, str]) -> str:
    """The model part of a 3MF file."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}">',
        *(
            f"<metadata name={quoteattr(name)}>{escape(value)}</metadata>"
            for name, value in metadata.items()
        ),
        "<resources>",
    ]
    for number, (name, placed) in enumerate(objects.items(), 1):
        lines += _object_lines(number, name, placed.mesh)
    lines += ["</resources>", "<build>"]
    for number, placed in enumerate(objects.values(), 1):
        x, y, z = (MILLIMETRES * placed.place).tolist()
        lines.append(f'<item objectid="{number}" transform="1 0 0 0 1 0 0 0 1 {x} {y} {z}"/>')
    return "\n".join([*lines, "</build>", "</model>", ""])


def _object_lines(number: int, name: str, mesh: trimesh.Trimesh) -> list[str]:
    vertices = [
        f'<vertex x="{x:.6f}" y="{y:.6f}" z="{z:.6f}"/>' for x, y, z in MILLIMETRES * mesh.vertices
    ]
    triangles = [f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces]
    return [
        f'<object id="{number}" type="model" name={quoteattr(name)}>',
        "<mesh>",
        "<vertices>",
        *vertices,
        "</vertices>",
        "<triangles>",
        *triangles,
        "</triangles>",
        "</mesh>",
        "</object>",
    ]
