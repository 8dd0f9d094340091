"""dexnet: the Dex-Net database of a dataset, with the labelled grasps of a gripper."""

from pathlib import Path

from egad.exchange import DexNetDatabase
from egad.exchange.exports import dexnet
from egad.workflow.job import run_job


def run(
    settings: DexNetDatabase,
    dataset: Path,
    gripper: str,
    parts: list[Path],
    grasps: Path,
    out: Path,
) -> None:
    """Combine the objects of all shards, and add their grasps.

    Args:
        settings: Settings of this format.
        dataset: Folder of the dataset.
        gripper: Name of the gripper.
        parts: The objects of the shards.
        grasps: Labelled grasps.
        out: HDF5 file.
    """
    dexnet.run(settings, dataset, gripper, parts, grasps, out)


if __name__ == "__main__":
    run_job(run)
