"""graspgen: grasps with simulated labels as a dataset of GraspGen."""

import logging
import shutil
from pathlib import Path

from egad._util.files import atomic_output, check_empty
from egad.exchange import (
    LEAST_POSITIVE,
    check_key,
    graspgen_hand,
    start_graspgen,
    write_graspgen,
)
from egad.exchange.exports._simulated import check_simulated, simulated_by_object
from egad.exchange.parameters import GripperFormat

log = logging.getLogger(__name__)


def run(
    settings: GripperFormat,
    gripper: str,
    meshes: Path,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write a dataset of GraspGen: grasps, meshes, lists of objects and the gripper.

    Args:
        settings: Settings of this format.
        gripper: Name of the gripper.
        meshes: Folder of the scaled meshes.
        simulated_grasps: Table with the columns of `tables.grasping.SIMULATED_GRASPS`, sorted by
            label.
        out: The simulated grasps for gripper G as a dataset of GraspGen, with meshes. Made if
            `targets.exports` contains `graspgen`. See `docs/exchange.md`.

    Raises:
        UserError: A name is not allowed, the grasps have no simulated labels, or the folder is not
            empty.
    """
    check_empty(out)
    check_simulated(simulated_grasps)
    hand = graspgen_hand(check_key(gripper, "gripper"), settings.gripper)
    with atomic_output(out, keep=False) as folder:
        start_graspgen(folder, hand)
        for label, rows in simulated_by_object(simulated_grasps):
            name = f"{check_key(label)}.obj"
            shutil.copyfile(meshes / name, folder / "objects" / name)
            held = write_graspgen(folder, hand, label, rows)
            if held < LEAST_POSITIVE:
                log.warning(
                    "%s has %d grasps that hold; GraspGen leaves objects with fewer than %d out",
                    label,
                    held,
                    LEAST_POSITIVE,
                )
