"""The archive of the released dataset: genomes and voxels of a full evolution."""

from pathlib import Path


def released() -> Path:
    """The archive that `config/released.yaml` starts from."""
    return Path(__file__).with_name("archive.parquet")


def archive_path(archive: Path) -> Path:
    """The file that a person means by an archive: `released` is the one shipped."""
    return released() if str(archive) == "released" else archive
