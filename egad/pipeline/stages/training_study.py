"""training-study: networks trained on different object sets, compared."""

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from egad._util.files import write_text
from egad.perception import files
from egad.pipeline.config import TrainingSet, TrainingStudy
from egad.pipeline.config.stage_settings import TrainingStudyReport
from egad.pipeline.config.training_study import Network, image_sets, networks
from egad.pipeline.parameters import Input, NotNoted, Output, command
from egad.pipeline.report.training_study import Images, Study, Training, object_sides, page
from egad.stats import check_starts, read
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SCALES
from egad.tables.training import CLEARED, COMPARED, HISTORY, SCORE

log = logging.getLogger(__name__)


@command()
def run(
    settings: TrainingStudyReport,
    gripper: str,
    results: Annotated[Path, NotNoted()],
    out: Annotated[Path, Output("training_study/report.html")],
    table: Annotated[Path, Output("training_study/results.parquet", COMPARED)],
    clutter: Annotated[Path, Output("training_study/clutter.parquet", CLEARED)],
    reads: Annotated[list[Path] | None, typer.Argument(), Input()] = None,
) -> None:
    """Compare networks that were trained on different object sets.

    Args:
        settings: Settings of this stage.
        gripper: Name of the gripper of the trials.
        results: Folder of all results.
        out: Comparison of networks trained on different object sets. Made only if named. See
            `docs/training.md`. The folder `training_study/images/SET/` contains the images of a
            training set, with the same layout as `D/images/G/`; `training_study/trials/D/` the
            trials by noise and detector, and `training_study/clutter/D/` the cleared tables, with
            the columns of `D/trials/G/P.parquet` and `D/clutter/G/P.parquet`.
        table: All attempts at single objects of all networks, and of the reference detectors.
        clutter: Their attempts in scenes of several objects.
        reads: Files that the report shows, for the provenance.

    Raises:
        UserError: Attempts that should start with the same drop do not.
    """
    del reads
    asked, sets = settings.training_study, settings.training_sets
    found = networks(sets, asked)
    made = results / "training_study"
    by_name = made_by(found, asked.references)
    tried = _all_attempts(made, by_name, asked)
    if settings.trials.reset == "redrop":
        for _, rows in tried.groupby("test"):
            check_starts(rows)
    cleared = _all_cleared(made, by_name, asked)
    trained = [each for each in found if not sets[each.training_set].weights]
    study = Study(
        settings=settings,
        trials=tried,
        cleared=cleared,
        widths={test: _widths(results / test, gripper) for test in asked.tests},
        images={each.training_set: images_of(made, each.training_set, sets) for each in trained},
        trainings={each: training_of(made / "networks" / each.folder) for each in trained},
    )
    write_text(out, page(study))
    parquet.write(tried, COMPARED, table)
    parquet.write(cleared, CLEARED, clutter)
    log.info("%d networks, %d attempts", len(found), len(tried) + len(cleared))


def made_by(found: list[Network], references: list[str]) -> dict[str, Network]:
    """Networks by name of the detector; references stand for themselves, with no training set."""
    return {each.name: each for each in found} | dict.fromkeys(references, Network("", 0))


def _all_attempts(
    made: Path, detectors: Mapping[str, Network], study: TrainingStudy
) -> pd.DataFrame:
    parts = [
        attempts(made / "trials" / test / noise / f"{name}.parquet", test, noise, network)
        for test in study.tests
        for noise in study.noise
        for name, network in detectors.items()
    ]
    return pd.concat(parts, ignore_index=True)


def _all_cleared(
    made: Path, detectors: Mapping[str, Network], study: TrainingStudy
) -> pd.DataFrame:
    parts = [
        cleared_tables(made / "clutter" / test / f"{name}.parquet", test, network)
        for test in (study.tests if study.clutter else ())
        for name, network in detectors.items()
    ]
    return pd.concat([parquet.empty(CLEARED), *parts], ignore_index=True)


def attempts(path: Path, test: str, noise: str, network: Network) -> pd.DataFrame:
    """The attempts at single objects of one detector, columns of `COMPARED`."""
    table = read(path)[path.stem].assign(test=test, noise=noise, **network._asdict())
    return table.loc[:, list(COMPARED.names)]


def cleared_tables(path: Path, test: str, network: Network) -> pd.DataFrame:
    """The attempts of one detector in scenes of several objects, columns of `CLEARED`."""
    table = parquet.read(path, CLUTTER).assign(test=test, detector=path.stem, **network._asdict())
    return table.loc[:, list(CLEARED.names)]


def sides_of(dataset: Path, gripper: str) -> dict[str, list[float]]:
    """The sides of each object of a test, metres, by label; from the dataset's results."""
    chosen = parquet.read(dataset / "eval49.parquet", EVAL49)
    return object_sides(
        chosen, parquet.read(dataset / "rescaled" / gripper / "scales.parquet", SCALES)
    )


def _widths(dataset: Path, gripper: str) -> dict[str, float]:
    return {label: sides[0] for label, sides in sides_of(dataset, gripper).items()}


def images_of(made: Path, name: str, training_sets: Mapping[str, TrainingSet]) -> Images:
    """The images of the split train that the networks of a set are trained on."""
    objects: set[tuple[str, str]] = set()
    count = 0
    for source in image_sets(name, training_sets):
        dataset = str(training_sets[source].dataset)
        for path in files(made / "images" / source):
            for rows in parquet.batches(path, ["objects", "split"]):
                train = rows.loc[rows["split"] == "train", "objects"]
                objects |= {(dataset, name) for names in train for name in names}
                count += len(train)
    return Images(frozenset(objects), count)


def training_of(folder: Path) -> Training:
    """How the network in a folder was trained."""
    score = parquet.records(parquet.read(folder / "score.parquet", SCORE))[0]
    return Training(parquet.read(folder / "history.parquet", HISTORY), score)
