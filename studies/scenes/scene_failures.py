"""Pictures of typical failures in piles: `python scene_failures.py RUN SET`.

RUN is the folder in which the study ran. In each test, the failed attempts of the networks of SET
in piles seen by six cameras without noise count. For each outcome of more than a tenth of these,
the picture shows the first such attempt at the object with most of them, in frames from when the
hand comes to when it leaves. Writes scenes_failures.png.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import yaml

sys.path.append(str(Path(__file__).parents[1]))
from pictures import chosen, save_sheet, typical  # type: ignore[import-not-found]
from scene_plan import FOLDER, condition_settings, networks_of, study_of
from write_scene_tables import CAMERAS, SCENE

from egad._util.arrays import RgbImage
from egad.bench import ClearedTables, ClutterParameters, Models, repeat_round
from egad.errors import UserError
from egad.exchange import bundle_models
from egad.sim import Film
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, ROUND
from egad_workflow.settings import select

PICTURE = Path(__file__).with_name("scenes_failures.png")
FRAMES = 6
NOISE = "none"
SHARE = 0.1  # of the failed attempts of a test, for an outcome to be shown


def main(run: Path, training_set: str) -> None:
    """Draw the picture."""
    study = study_of(yaml.safe_load(Path(__file__).with_name("study.yaml").read_text("utf-8")))
    settings, hand = condition_settings(study, CAMERAS), study.settings.targets.grippers[0]
    networks = [name for name, (of, _) in networks_of(study.plan).items() if of == training_set]
    rows = []
    for test in study.plan.tests:
        models = bundle_models(run / "results" / test / "bundle" / hand)
        folder = run / FOLDER / "clutter" / test / CAMERAS
        tables = [
            parquet.read(folder / f"{name}.parquet", CLUTTER).assign(detector=name)
            for name in networks
        ]
        attempts = pd.concat(tables)
        piles = attempts[(attempts["scene"] == SCENE) & (attempts["noise"] == NOISE)]
        for _, attempt in typical(piles, "id", SHARE).iterrows():
            this = select(settings, ClearedTables, hand, attempt["detector"])
            own = attempts[attempts["detector"] == attempt["detector"]]
            title = f"{test}, {attempt['id']}: {attempt['outcome'].replace('_', ' ')}"
            rows.append((title, frames_of(attempt, own, models, this)))
    save_sheet(rows, PICTURE, colors=256)


def frames_of(
    attempt: pd.Series, attempts: pd.DataFrame, models: Models, settings: ClutterParameters
) -> Sequence[RgbImage]:
    """Frames of one attempt: those of its round up to its end, less those before it."""
    rows = attempts[(attempts[ROUND] == attempt[ROUND]).all(axis=1)]
    until = rows[rows["attempt"] <= attempt["attempt"]]
    earlier = film_of(until.iloc[:-1], models, settings)
    found: Sequence[RgbImage] = chosen(film_of(until, models, settings)[len(earlier) :], FRAMES)
    return found


def film_of(rows: pd.DataFrame, models: Models, settings: ClutterParameters) -> Sequence[RgbImage]:
    """Frames of a round up to the end of some of its first attempts; none if there are none.

    Raises:
        UserError: The attempts ended differently.
    """
    if rows.empty:
        return []
    films: list[Film] = []
    again = repeat_round(rows, models, settings, lambda world: films.append(Film(world)))
    if again["outcome"].tolist()[: len(rows)] != rows["outcome"].tolist():
        raise UserError("the round was not reproduced: was it made by another version?")
    return films[0].frames


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
