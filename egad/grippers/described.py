"""Hands described by a URDF or MJCF file: MuJoCo is loaded only if there is such a file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from egad._util.extras import needed_for
from egad.grippers.model import GripperModel

FILE = "a gripper with a URDF or MJCF file"


def read_described(path: Path, values: Mapping[str, Any]) -> GripperModel:
    """The hand that a file describes; settings that override what is found in the file count."""
    with needed_for(FILE):
        from egad.grippers.reading import choices_of, read_model  # noqa: PLC0415 (an extra)
    return read_model(path, choices_of(values))


def description_files(path: Path) -> list[Path]:
    """A description and the files of all its meshes.

    Raises:
        UserError: One of them cannot be used, or MuJoCo is not installed.
    """
    with needed_for(FILE):
        from egad.grippers import description  # noqa: PLC0415 (an extra)
    return description.description_files(path)
