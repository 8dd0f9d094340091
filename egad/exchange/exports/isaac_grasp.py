"""isaac_grasp: grasps with simulated labels as files of Isaac Sim's Grasp Editor."""

from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad.exchange import check_articulated, check_key, write_isaac_grasp
from egad.exchange.exports._simulated import check_simulated, simulated_by_object
from egad.exchange.parameters import GripperFormat


def run(
    settings: GripperFormat,
    gripper: str,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write a file for each object that has grasps.

    Args:
        settings: Settings of this format.
        gripper: Name of the gripper.
        simulated_grasps: Table with the columns of `tables.grasping.SIMULATED_GRASPS`, sorted by
            label.
        out: The simulated grasps for gripper G as isaac_grasp files, in the frame of
            `D/rescaled/G/LABEL.obj`. Made if `targets.exports` contains `isaac_grasp`, for a
            gripper with a `file`. See `docs/exchange.md`.

    Raises:
        UserError: The gripper has no joints, a name is not allowed, the grasps have no simulated
            labels, or the folder is not empty.
    """
    check_empty(out)
    check_articulated(gripper, settings.gripper)
    check_simulated(simulated_grasps)
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        for label, rows in simulated_by_object(simulated_grasps):
            path = folder / f"{check_key(label)}.yaml"
            write_isaac_grasp(path, label, settings.gripper, rows)
