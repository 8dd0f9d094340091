"""The released dataset: archive, ancestors, simulated grasps, evaluation set and a network."""

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


def released_graphs() -> Path:
    """Reeb graphs of the released objects; `python -m egad.cli.released_graphs` makes them."""
    return Path(__file__).with_name("graphs.parquet")


def evaluation_set() -> Path:
    """The evaluation set of the released objects: columns label and id."""
    return Path(__file__).with_name("evaluation_set.csv")


def archive_path(archive: Path) -> Path:
    """The file of an archive that a user names: `released` is the one shipped."""
    return released() if str(archive) == "released" else archive
