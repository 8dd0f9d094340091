"""Functions shared by the formats of rendered images."""

import logging
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.errors import UserError
from egad.perception.image_shards import Images, files, shards
from egad.perception.rendering import Picture
from egad.perception.splits import SPLITS
from egad.pipeline.config import Gripper
from egad.pipeline.config.stage_settings import StageSettings
from egad.pipeline.parameters import Input

log = logging.getLogger(__name__)


def _shards(given: Mapping[str, Any]) -> list[Path]:
    return files(given["images"])


IMAGES = Input(files=_shards)  # all shards of a folder


class ImageLayouts(StageSettings):
    """Rendered images laid out as other datasets."""

    gripper: Gripper


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


def check_folder(out: Path) -> None:
    """Check that an export into a folder replaces no file.

    Raises:
        UserError: It would.
    """
    if out.is_file():
        raise UserError(f"--out {out} is a file; name a folder")


def check_empty(out: Path) -> None:
    """Check that a folder is empty or new.

    Raises:
        UserError: It is not empty, or is a file.
    """
    check_folder(out)
    if out.is_dir() and any(out.iterdir()):
        raise UserError(f"--out {out} is not empty, and its files would be lost")
