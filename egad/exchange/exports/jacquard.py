"""jacquard: rendered images with grasps, laid out as in Jacquard."""

from pathlib import Path

from egad.exchange import write_jacquard
from egad.exchange.exports._images import write_by_split
from egad.exchange.parameters import GripperFormat


def run(
    settings: GripperFormat,
    images: Path,
    out: Path,
) -> None:
    """Write a set of images in the layout of Jacquard.

    Args:
        settings: Settings of this format.
        images: Folder with `images-N.parquet`.
        out: Rendered images with grasps for gripper G in the layout of Jacquard. Made if
            `targets.exports` contains `jacquard`. See `docs/images.md`.

    Raises:
        UserError: Shards are missing, or the images do not fit the layout.
    """
    write_by_split(
        images, out, lambda picture, folder: write_jacquard(picture, settings.gripper, folder)
    )
