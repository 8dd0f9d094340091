"""graspnet: grasps with simulated labels as the arrays of graspnetAPI."""

from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad.exchange import check_key, write_graspnet
from egad.exchange.exports._simulated import check_simulated, simulated_by_object
from egad.exchange.parameters import GripperFormat


def run(
    settings: GripperFormat,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write an array for each object that has grasps.

    Args:
        settings: Settings of this format.
        simulated_grasps: Table with the columns of `tables.grasping.SIMULATED_GRASPS`, sorted by
            label.
        out: The simulated grasps for gripper G as arrays of graspnetAPI, in the frame of
            `D/rescaled/G/LABEL.obj`. Made if `targets.exports` contains `graspnet`. See
            `docs/exchange.md`.

    Raises:
        UserError: A name is not allowed, the grasps have no simulated labels, or the folder is not
            empty.
    """
    check_empty(out)
    check_simulated(simulated_grasps)
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        for label, rows in simulated_by_object(simulated_grasps):
            write_graspnet(folder, check_key(label), rows, settings.gripper.opening)
