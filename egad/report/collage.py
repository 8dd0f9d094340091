"""One picture of a whole dataset: its objects over the space that they span."""

import io
from collections.abc import Mapping
from pathlib import Path

import matplotlib
import pandas as pd
from PIL import Image, ImageDraw, ImageFont

from egad.measures.parameters import Space
from egad.report.axes import USUAL, AxisPair

INK = (28, 36, 48)
GROUND = (236, 238, 242)


def collage(
    objects: pd.DataFrame,
    pictures: Mapping[str, bytes],
    space: Space,
    unit: int = 48,
    axes: AxisPair = USUAL,
) -> bytes:
    """Draw the most diverse object of every cell, complexity across and difficulty upwards.

    Args:
        objects: Columns of `tables.objects.OBJECTS`.
        pictures: PNG of each object by its label, with a transparent ground; objects without
            one are left out.
        space: The cells.
        unit: Pixels a side of a cell.
        axes: What is written along the axes.

    Returns:
        A PNG file.
    """
    side, margin = unit * space.cells, unit
    image = Image.new("RGB", (side + margin, side + margin), "white")
    pictured = objects[objects["label"].isin(list(pictures))]
    for item in most_diverse(pictured).to_dict("records"):
        place = (
            margin + int(item["complexity_cell"]) * unit,
            (space.cells - 1 - int(item["difficulty_cell"])) * unit,
        )
        _paste(image, pictures[item["label"]], place, unit)
    _write(image, axes.across.long_label, (margin + side // 2, side + margin // 2), unit)
    turned = image.transpose(Image.Transpose.ROTATE_270)
    _write(turned, axes.upwards.long_label, (turned.width - side // 2, margin // 2), unit)
    buffer = io.BytesIO()
    turned.transpose(Image.Transpose.ROTATE_90).save(buffer, "png", optimize=True)
    return buffer.getvalue()


def most_diverse(objects: pd.DataFrame) -> pd.DataFrame:
    """The most diverse object of every cell."""
    ordered = objects.sort_values(["diversity", "label"], ascending=[False, True])
    return ordered.drop_duplicates(["complexity_cell", "difficulty_cell"])


def _paste(image: Image.Image, content: bytes, place: tuple[int, int], unit: int) -> None:
    picture = Image.open(io.BytesIO(content)).convert("RGBA")
    drawn = picture.resize((unit - 4, unit - 4), Image.Resampling.LANCZOS)
    image.paste(GROUND, (place[0] + 1, place[1] + 1, place[0] + unit - 1, place[1] + unit - 1))
    image.paste(drawn, (place[0] + 2, place[1] + 2), drawn)


def _write(image: Image.Image, text: str, centre: tuple[int, int], unit: int) -> None:
    name = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    font = ImageFont.truetype(name, 0.4 * unit)
    ImageDraw.Draw(image).text(centre, text, fill=INK, font=font, anchor="mm")
