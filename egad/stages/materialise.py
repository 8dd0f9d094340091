"""materialise: the meshes of an archive, for people who want just those."""

from pathlib import Path

from egad import tables
from egad.exchange.meshes import write_obj
from egad.files import replacing
from egad.measures.space import labels
from egad.progress import progress
from egad.settings import Shape
from egad.shapes import voxels
from egad.shapes.surface import surface


def run(archive: Path, out: Path) -> int:
    """Write every object of an archive as `LABEL.obj`, in metres; return how many."""
    frame = tables.read(archive, tables.ARCHIVE)
    names = labels(frame["complexity_cell"], frame["difficulty_cell"])
    with replacing(out) as folder:
        folder.mkdir()
        objects = zip(names, frame["voxels"], strict=True)
        for name, packed in progress(objects, "writing meshes", len(names)):
            resolution = round((8 * len(packed)) ** (1 / 3))
            mesh = surface(voxels.unpack(packed, resolution), Shape(resolution=resolution))
            write_obj(mesh, folder / f"{name}.obj")
    return len(names)
