"""The page about the study, and the tables of all attempts: networks of different sets compared."""

import logging
from pathlib import Path

from network_statistics import check_starts
from study import PageSettings
from study_page import Results, page
from study_results import all_attempts, all_cleared, images_of, made_by, training_of, widths_of
from study_tables import CLEARED, COMPARED

from egad._util.files import write_text
from egad.tables import parquet
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: PageSettings,
    gripper: str,
    results: Path,
    out: Path,
    table: Path,
    clutter: Path,
) -> None:
    """Compare networks that were trained on different object sets.

    Args:
        settings: What the page reads.
        gripper: Name of the gripper of the trials.
        results: Folder of all results.
        out: The page.
        table: All attempts at single objects of all networks, and of the reference detectors.
        clutter: Their attempts in scenes of several objects.

    Raises:
        UserError: Attempts that should start with the same drop do not.
    """
    plan = settings.plan
    made = results / "training_study"
    by_name = made_by(plan.networks, plan.references)
    tried = all_attempts(made, by_name, plan)
    if settings.trials.reset == "redrop":
        for _, rows in tried.groupby("test"):
            check_starts(rows)
    cleared = all_cleared(made, by_name, plan)
    found = Results(
        settings=settings,
        trials=tried,
        cleared=cleared,
        widths={test: widths_of(results / test, gripper) for test in plan.tests},
        images={
            each.training_set: images_of(made, each.training_set, plan) for each in plan.trained
        },
        trainings={each: training_of(made / "networks" / each.folder) for each in plan.trained},
    )
    write_text(out, page(found))
    parquet.write(tried, COMPARED, table)
    parquet.write(cleared, CLEARED, clutter)
    log.info("%d networks, %d attempts", len(plan.networks), len(tried) + len(cleared))


if __name__ == "__main__":
    run_job(run)
