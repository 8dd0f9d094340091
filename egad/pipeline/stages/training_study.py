"""training-study: networks trained on different object sets, compared."""

import logging
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from egad._util.files import write_text
from egad.perception import files
from egad.pipeline.config.stage_settings import TrainingStudyReport
from egad.pipeline.config.training_study import Network, networks
from egad.pipeline.parameters import Input, NotNoted, Output, command
from egad.pipeline.report.training_study import Images, Study, Training, page
from egad.report.axes import axis_pair
from egad.report.trials import EvaluationSet
from egad.stats import check_starts, read
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.training import COMPARED, HISTORY, SCORE

log = logging.getLogger(__name__)


@command()
def run(
    settings: TrainingStudyReport,
    gripper: str,
    results: Annotated[Path, NotNoted()],
    out: Annotated[Path, Output("training_study/report.html")],
    table: Annotated[Path, Output("training_study/results.parquet", COMPARED)],
    reads: Annotated[list[Path] | None, typer.Argument(), Input()] = None,
) -> None:
    """Compare networks that were trained on different object sets.

    Args:
        settings: Settings of this stage.
        gripper: Name of the gripper of the trials.
        results: Folder of all results.
        out: Comparison of networks trained on different object sets. Made only if named. See
            `docs/training-study.md`. The folder `training_study/images/SET/` contains the images of
            a training set, with the same layout as `D/images/G/`.
        table: All attempts of all networks, and of the reference detectors.
        reads: Files that the report shows, for the provenance.

    Raises:
        UserError: Attempts that should start with the same drop do not.
    """
    del reads
    asked = settings.training_study
    found = networks(settings.training_sets, asked.sets, asked.seeds)
    trials = pd.concat(
        _attempts(results / test / "trials" / gripper, test, found, asked.references)
        for test in asked.tests
    )
    if settings.trials.reset == "redrop":
        for _, rows in trials.groupby("test"):
            check_starts(rows)
    trained = [each for each in found if settings.training_sets[each.training_set].dataset]
    made = results / "training_study"
    study = Study(
        settings=settings,
        table=trials,
        tests={test: _set(results / test / "eval49.parquet", settings) for test in asked.tests},
        images={each.training_set: _images(made, each.training_set) for each in trained},
        trainings={each: _training(made / "networks" / each.folder) for each in trained},
    )
    write_text(out, page(study))
    parquet.write(trials, COMPARED, table)
    log.info("%d networks, %d attempts", len(found), len(trials))


def _attempts(folder: Path, test: str, found: list[Network], references: list[str]) -> pd.DataFrame:
    """All attempts of a test, columns of `COMPARED`."""
    made_by = {each.name: (each.training_set, each.seed) for each in found}
    made_by |= dict.fromkeys(references, ("", 0))
    parts = [
        read(folder / f"{name}.parquet")[name].assign(test=test, training_set=chosen, seed=seed)
        for name, (chosen, seed) in made_by.items()
    ]
    return pd.concat(parts, ignore_index=True).loc[:, list(COMPARED.names)]


def _set(evaluation: Path, settings: TrainingStudyReport) -> EvaluationSet:
    grid = settings.select_eval
    chosen = parquet.read(evaluation, EVAL49)
    return EvaluationSet(grid.rows, grid.columns, chosen, axis_pair(settings.measures))


def _images(made: Path, name: str) -> Images:
    batches = [
        rows
        for path in files(made / "images" / name)
        for rows in parquet.batches(path, ["id", "split"])
    ]
    rows = pd.concat(batches)
    train = rows.loc[rows["split"] == "train", "id"]
    return Images(frozenset(train), len(train))


def _training(folder: Path) -> Training:
    score = parquet.records(parquet.read(folder / "score.parquet", SCORE))[0]
    return Training(parquet.read(folder / "history.parquet", HISTORY), score)
