"""The formats of exports: the modules in `egad/pipeline/exports/`, found without importing any."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

FOLDER = Path(__file__).parents[1] / "exports"


def formats() -> list[str]:
    """The names of all formats."""
    return sorted(path.stem for path in FOLDER.glob("[!_]*.py"))


if TYPE_CHECKING:
    Format = str
else:
    Format = Literal[tuple(formats())]
