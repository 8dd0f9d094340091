"""cornell: rendered images with grasps, laid out as in Cornell."""

from pathlib import Path

from egad.exchange import write_cornell
from egad.exchange.exports._images import write_by_split
from egad.exchange.parameters import GripperFormat


def run(
    settings: GripperFormat,
    images: Path,
    out: Path,
) -> None:
    """Write a set of images in the layout of Cornell.

    Args:
        settings: Settings of this format.
        images: Folder with `images-N.parquet`.
        out: Rendered images with grasps for gripper G in the layout of Cornell. Made if
            `targets.exports` contains `cornell`. See `docs/images.md`.

    Raises:
        UserError: Shards are missing, or the images do not fit the layout.
    """
    write_by_split(
        images, out, lambda picture, folder: write_cornell(picture, settings.gripper, folder)
    )
