"""gqcnn: rendered images with grasps, laid out as in the training sets of GQ-CNN."""

import logging
from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad.exchange import write_gqcnn
from egad.exchange.exports._images import pictures
from egad.exchange.parameters import GripperFormat

log = logging.getLogger(__name__)


def run(
    settings: GripperFormat,
    images: Path,
    out: Path,
) -> None:
    """Write a set of images in the layout of GQ-CNN.

    Args:
        settings: Settings of this format.
        images: Folder with `images-N.parquet`.
        out: Rendered images with grasps for gripper G in the layout of GQ-CNN. Made if
            `targets.exports` contains `gqcnn`. See `docs/images.md`.

    Raises:
        UserError: Shards are missing, or the images do not fit the layout.
    """
    del settings
    check_empty(out)
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        log.info("%d rows", write_gqcnn(pictures(images), folder))
