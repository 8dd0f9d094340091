import io

import numpy as np
import pandas as pd
from PIL import Image

from egad.measures import MeasureSpace
from egad.report.space_map import collage, shown_objects, space_map


def square(tone: int) -> bytes:
    buffer = io.BytesIO()
    Image.new("RGBA", (8, 8), (tone, tone, tone, 255)).save(buffer, "png")
    return buffer.getvalue()


def drawn(objects: pd.DataFrame, pictures: dict[str, bytes]) -> np.ndarray:
    content = collage(objects, pictures, MeasureSpace(cells=5), unit=20)
    assert content == collage(objects, pictures, MeasureSpace(cells=5), unit=20)
    return np.asarray(Image.open(io.BytesIO(content)))


def test_objects_lie_in_their_cells_and_the_most_diverse_is_on_top():
    objects = pd.DataFrame(
        {
            "label": ["a", "b", "c", "unseen"],
            "complexity_cell": [0, 0, 4, 2],
            "difficulty_cell": [0, 0, 4, 2],
            "diversity": [0.1, 0.3, 0.2, 0.9],
        }
    )
    image = drawn(objects, {"a": square(10), "b": square(90), "c": square(170)})
    assert image.shape == (120, 120, 3)

    def center(column: int, row: int) -> list[int]:
        return image[(4 - row) * 20 + 10, 20 + column * 20 + 10].tolist()

    assert center(0, 0) == [90] * 3
    assert center(4, 4) == [170] * 3
    assert center(2, 2) == center(4, 0) == [255] * 3


def test_the_map_needs_pictures_of_the_objects_that_it_shows_only(objects, pictures):
    shown = shown_objects(objects)
    assert len(shown) < len(objects)
    few = {label: pictures[label] for label in shown}
    assert space_map(objects, few, MeasureSpace()) == space_map(objects, pictures, MeasureSpace())
