"""jacquard: rendered images with grasps, laid out as in Jacquard."""

from pathlib import Path
from typing import Annotated

from egad.exchange import write_jacquard
from egad.pipeline.exports._images import IMAGES, ImageLayouts, write_by_split
from egad.pipeline.parameters import Output


def run(
    settings: ImageLayouts,
    images: Annotated[Path, IMAGES],
    out: Annotated[Path, Output("D/exchange/G-jacquard/")],
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
