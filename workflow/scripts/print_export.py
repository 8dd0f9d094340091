"""print-export: STL files and 3MF plates of the evaluation set, in millimetres."""

from pathlib import Path

from egad.config.stages import PrintFiles
from egad.workflow.job import run_job
from egad.workflow.print_files import write_print_files


def run(
    settings: PrintFiles,
    gripper: str,
    evaluation: Path,
    meshes: Path,
    scales: Path,
    out: Path,
    grasps: Path | None = None,
) -> None:
    """Write STL and 3MF files of the evaluation set, in millimetres.

    An object without a mesh, too thin, or too large for the bed gets a note in the table instead
    of files.

    Args:
        settings: Gripper, bed, pose, limits of the printer.
        gripper: Name of the gripper, for the plates.
        evaluation: Evaluation set.
        meshes: Folder of the scaled meshes.
        scales: Table of the scales, in that folder.
        out: Folder with the evaluation set for gripper G, in millimetres: STL files, plates of
            named objects, and a table of the objects on each plate.
        grasps: Labelled grasps; engraved labels avoid their contacts.
    """
    write_print_files(settings, gripper, evaluation, meshes, scales, out, grasps)


if __name__ == "__main__":
    run_job(run)
