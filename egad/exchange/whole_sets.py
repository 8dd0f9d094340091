"""Results of a run in formats of objects and of images: the loop over all of them."""

import logging
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from egad._util.progress import progress
from egad.exchange.new_folder import new_folder
from egad.exchange.objects.simulation import read_convex_objects, read_simulation_object
from egad.exchange.parameters import AllObjects, GripperFormat
from egad.grippers import Gripper
from egad.io import read_mesh, write_mesh
from egad.learning.images import Images, RenderedImage, shards
from egad.sim import SimulationObject
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE

# Arguments: a folder, the name of the object, itself and its friction.
WriteObject = Callable[[Path, str, SimulationObject, float], None]
WriteImages = Callable[[Iterable[RenderedImage], Gripper, Path], int]

log = logging.getLogger(__name__)


def write_evaluation_set(
    settings: GripperFormat, write: WriteObject, bundle: Path, out: Path
) -> None:
    """Write the objects of a simulation bundle."""
    del settings
    rows = parquet.records(parquet.read(bundle / "bundle.parquet", BUNDLE))
    with new_folder(out) as folder:
        for row in progress(rows, "writing objects", len(rows)):
            write(folder, row["label"], read_simulation_object(bundle, row), row["friction"])
    log.info("%d objects", len(rows))


def write_all(
    settings: AllObjects, write: WriteObject, meshes: Path, convex_parts: Path, out: Path
) -> None:
    """Write all objects of a dataset, in the order of its table of convex parts."""
    labels, written = {path.stem for path in meshes.glob("*.obj")}, set()
    found = read_convex_objects(convex_parts, meshes, settings.material.density)
    with new_folder(out) as folder:
        for label, made in progress(found, "writing objects", len(labels)):
            write(folder, label, made, settings.bundle.friction)
            written.add(label)
    for label in sorted(labels - written):
        log.warning("%s is left out: it has no convex parts in %s", label, convex_parts)
    log.info("%d objects", len(written))


def write_all_surfaces(settings: GripperFormat, ending: str, meshes: Path, out: Path) -> None:
    """Write the surfaces of all objects of a dataset."""
    del settings
    paths = sorted(meshes.glob("*.obj"))
    with new_folder(out) as folder:
        for path in progress(paths, "writing objects", len(paths)):
            write_mesh(read_mesh(path, "m"), folder / f"{path.stem}.{ending}")
    log.info("%d objects", len(paths))


def write_images(settings: GripperFormat, write: WriteImages, images: Path, out: Path) -> None:
    """Write a set of rendered images."""
    with new_folder(out) as folder:
        write(_pictures(images), settings.gripper, folder)


def _pictures(images: Path) -> Iterator[RenderedImage]:
    """All images of a folder; one shard at a time is in memory."""
    for table in shards(images):
        yield from progress(Images(table), "writing images", len(table))
