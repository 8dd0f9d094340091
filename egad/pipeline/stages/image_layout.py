"""image-layout: rendered images laid out as other datasets are."""

import logging
from collections.abc import Callable, Iterator
from pathlib import Path

from egad._util.files import replacing
from egad._util.progress import progress
from egad.exchange.cornell import write_cornell
from egad.exchange.gqcnn import write_gqcnn
from egad.exchange.jacquard import write_jacquard
from egad.perception.image_shards import Images, shards
from egad.perception.rendering import Picture
from egad.perception.splits import SPLITS
from egad.pipeline.config import Gripper
from egad.pipeline.config.stage_settings import ImageLayouts

log = logging.getLogger(__name__)
IN_FOLDERS: dict[str, Callable[[Picture, Gripper, Path], bool]] = {
    "jacquard": write_jacquard,
    "cornell": write_cornell,
}
LAYOUTS = (*IN_FOLDERS, "gqcnn")


def run(settings: ImageLayouts, layout: str, images: Path, out: Path) -> None:
    """Write a set of images in another layout, a folder a split where that has none of its own.

    Args:
        settings: What this stage reads.
        layout: One of `LAYOUTS`.
        images: Folder with `images-N.parquet`.
        out: Folder to write.

    Raises:
        UserError: Shards are missing, or the images do not fit the layout.
    """
    with replacing(out, keep=False) as folder:
        folder.mkdir()
        if layout == "gqcnn":
            log.info("%d rows", write_gqcnn(_all(images), folder))
            return
        for split in SPLITS:
            (folder / split).mkdir()
        write, written, total = IN_FOLDERS[layout], 0, 0
        for picture in _all(images):
            written += write(picture, settings.gripper, folder / picture.split)
            total += 1
    log.info("%d of %d images", written, total)


def _all(images: Path) -> Iterator[Picture]:
    """Every picture, a shard at a time in memory."""
    for table in shards(images):
        yield from progress(Images(table), "writing images", len(table))
