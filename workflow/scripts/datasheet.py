"""datasheet: a readable description of an evaluation set."""

from pathlib import Path

from egad.config.stages import DataSheets
from egad.workflow.datasheet import write_datasheet
from egad.workflow.job import run_job


def run(
    settings: DataSheets,
    dataset: str,
    evaluation: Path,
    grippers: list[str],
    manifests: list[Path],
    grasps: list[Path],
    out: Path,
) -> None:
    """Write the datasheet of an evaluation set.

    Args:
        settings: Grid and printing.
        dataset: Name of the dataset.
        evaluation: Evaluation set.
        grippers: Names of the grippers; pictures show the first.
        manifests: Tables of print files for these grippers.
        grasps: Labelled grasps for these grippers.
        out: Folder with the datasheet of the evaluation set (objects, sizes, how to report
            results), a contact sheet of its objects with names and sizes, and an empty table for
            attempts with a real robot.
    """
    write_datasheet(settings, dataset, evaluation, grippers, manifests, grasps, out)


if __name__ == "__main__":
    run_job(run)
