"""What failures look like in the study of failures as training data: `curriculum_failures.py RUN`.

RUN has the folders of `curriculum.py`, one for each set of networks. For some of the failures that
searches found, all unlike each other, docs/studies/curriculum_failures.png shows the object and
frames of an attempt that failed where the reference succeeded. The tables that are printed compare
such failures with objects at which the networks succeed: their shape, and the outcomes of attempts.
"""

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from curriculum import HELD_OUT, LEARNT, atlases_of
from failures import unlike
from pictures import HEIGHT, WIDTH, chosen, save_sheet
from PIL import Image

from egad._util.arrays import RgbImage
from egad._util.markdown import table as markdown
from egad.bench.failures import SHAPE_FEATURES, FailureAtlas, film_attempts, shape_features
from egad.bench.failures.search import scaled_surface
from egad.report.failure_atlas import film_rows, solved_objects
from egad.report.pictures import render

PICTURE = Path(__file__).parents[1] / "docs/studies/curriculum_failures.png"
SHOWN = 3  # objects of each folder
FRAMES = 5
SOLVED = 50  # objects of each search at which the network succeeds
SHAPE = ("grasp_size", "concavity", "complexity")
OUTCOMES = ("success", "collided", "slipped_lifting", "slipped_closing", "missed")


def main(run: Path) -> None:
    """Draw the picture, and print the tables."""
    pictures: list[tuple[str, list[RgbImage]]] = []
    lines, ends = [], []
    for folder in sorted(path.parent for path in run.glob("*/searches")):
        atlases = [*atlases_of(folder, HELD_OUT), *atlases_of(folder, LEARNT)]
        failures = pd.concat([each.table.assign(atlas=n) for n, each in enumerate(atlases)])
        failures = failures.iloc[unlike(failures["voxels"])]
        solved = pd.concat(
            solved_objects(each.examined, seed=0).head(SOLVED).assign(atlas=n)
            for n, each in enumerate(atlases)
        )
        pictures += [row_of(folder.name, row, atlases) for row in rows_of(failures)[:SHOWN]]
        for name, objects, purpose in (
            ("failures", rows_of(failures), "confirm"),
            ("successes", rows_of(solved), "screen"),
        ):
            lines.append((folder.name, name, len(objects), *shapes(objects, atlases)))
            ends.append((folder.name, name, *outcomes(objects, atlases, purpose)))
    save_sheet(pictures, PICTURE, colors=256)
    titles = [f"{SHAPE_FEATURES[name].title}, {SHAPE_FEATURES[name].unit}" for name in SHAPE]
    print(markdown(["networks", "objects", "number", *titles], lines))
    print(markdown(["networks", "at", "attempts", *OUTCOMES], ends))


def rows_of(objects: pd.DataFrame) -> list[pd.Series]:
    """The rows of a table."""
    return [row for _, row in objects.iterrows()]


def row_of(
    networks: str, failure: pd.Series, atlases: Sequence[FailureAtlas]
) -> tuple[str, list[RgbImage]]:
    """An object, and frames of a failed attempt at it."""
    settings = atlases[failure["atlas"]].searched_with()
    mesh = scaled_surface(failure["voxels"], settings)
    tried = film_rows(attempts_at(failure, atlases), settings.failures.engines[0])
    tried = tried[(tried["who"] == "detector") & (tried["pose"].map(len) > 0)]
    frames = [
        each for film in film_attempts(mesh, tried, settings) for each in chosen(film, FRAMES)
    ]
    outcomes = "".join(f": {each}".replace("_", " ") for each in tried["outcome"])
    return f"{networks}, {failure['id']}{outcomes}", [on_white(render(mesh, WIDTH)), *frames]


def shapes(objects: Iterable[pd.Series], atlases: Sequence[FailureAtlas]) -> list[str]:
    """Medians of shape features, with the range of the middle 80 % of the objects."""
    found = []
    for row in objects:
        settings = atlases[row["atlas"]].searched_with()
        mesh = scaled_surface(row["voxels"], settings)
        measured = shape_features(mesh, attempts_at(row, atlases), settings.gripper)
        found.append(measured | {"complexity": row["complexity"]})
    quantiles = pd.DataFrame(found)[list(SHAPE)].quantile([0.5, 0.1, 0.9])
    return [
        "{:.3g} ({:.3g} to {:.3g})".format(*SHAPE_FEATURES[name].factor * quantiles[name])
        for name in SHAPE
    ]


def outcomes(
    objects: Iterable[pd.Series], atlases: Sequence[FailureAtlas], purpose: str
) -> list[str]:
    """Number of attempts of a network for a purpose, and the percentage of each outcome."""
    tried = pd.concat([attempts_at(row, atlases) for row in objects])
    tried = tried[(tried["who"] == "detector") & (tried["purpose"] == purpose)]
    shares = tried["outcome"].value_counts(normalize=True)
    return [str(len(tried)), *(f"{100 * shares.get(name, 0):.0f}" for name in OUTCOMES)]


def attempts_at(row: pd.Series, atlases: Sequence[FailureAtlas]) -> pd.DataFrame:
    """The attempts at an object in its search."""
    attempts = atlases[row["atlas"]].attempts
    own: pd.DataFrame = attempts[attempts["id"] == row["id"]]
    return own


def on_white(picture: RgbImage) -> RgbImage:
    """A square picture with alpha on a white one of the size of frames."""
    sheet = Image.new("RGBA", (WIDTH, HEIGHT), "white")
    sheet.alpha_composite(Image.fromarray(picture), (0, (HEIGHT - WIDTH) // 2))
    return np.asarray(sheet.convert("RGB"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
