"""The released dataset: the archive of a full evolution, ancestors, and simulated grasps."""

from pathlib import Path


def released() -> Path:
    """The archive that `config/released.yaml` starts from."""
    return Path(__file__).with_name("archive.parquet")


def released_ancestry() -> Path:
    """The released objects and all their ancestors: columns as in `results/D/ancestry.parquet`."""
    return Path(__file__).with_name("ancestry.parquet")


def released_simulated() -> Path:
    """How often simulated grasps of the released objects hold.

    Columns as in `results/D/simulated/G.parquet`, for the gripper `egad_75mm`.
    """
    return Path(__file__).with_name("simulated.parquet")


def archive_path(archive: Path) -> Path:
    """The file that a person means by an archive: `released` is the one shipped."""
    return released() if str(archive) == "released" else archive
