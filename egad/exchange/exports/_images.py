"""Functions shared by the formats of rendered images."""

import logging
from collections.abc import Callable, Iterator
from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad._util.progress import progress
from egad.perception import SPLITS, Images, Picture, shards

log = logging.getLogger(__name__)


def write_by_split(images: Path, out: Path, write: Callable[[Picture, Path], bool]) -> None:
    """Write a set of images, one folder per split.

    Args:
        images: Folder with `images-N.parquet`.
        out: Folder to write.
        write: Writes an image into the folder of its split; false if it is not supported.

    Raises:
        UserError: Shards are missing, the images do not fit the format, or the folder has files.
    """
    check_empty(out)
    written, total = 0, 0
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        for split in SPLITS:
            (folder / split).mkdir()
        for picture in pictures(images):
            written += write(picture, folder / picture.split)
            total += 1
    log.info("%d of %d images", written, total)


def pictures(images: Path) -> Iterator[Picture]:
    """All pictures of a folder; one shard at a time is in memory."""
    for table in shards(images):
        yield from progress(Images(table), "writing images", len(table))
