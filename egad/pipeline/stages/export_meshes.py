"""export_meshes: the meshes of an archive."""

from pathlib import Path

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.cppn import packed_surface
from egad.exchange import write_obj
from egad.pipeline.config import Shape
from egad.tables import parquet
from egad.tables.columns import check_names
from egad.tables.evolution import ARCHIVE


def run(archive: Path, out: Path, shape: Shape) -> int:
    """Write every object of an archive as `ID.obj`, in metres, as measured during evolution.

    Args:
        archive: Table with the columns of `tables.evolution.ARCHIVE`.
        out: Folder to make.
        shape: The settings that the archive was evolved with.

    Returns:
        Number of meshes written.

    Raises:
        TableError: The archive is damaged, or an id in it is not a valid file name.
    """
    frame = parquet.read(archive, ARCHIVE)
    check_names(frame, archive, ["id"])
    objects = zip(frame["id"], frame["voxels"], strict=True)
    with atomic_output(out) as folder:
        folder.mkdir()
        for object_id, packed in progress(objects, "writing meshes", len(frame)):
            write_obj(packed_surface(packed, shape), folder / f"{object_id}.obj")
    return len(frame)
