"""Exports in the formats of other programs: each module is a format with the same name.

Its function `run` reads what its parameters name (`SOURCES`) and writes the folder `out`. `egad
export`, `targets.exports` and the rule `export` then know the format.
"""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from egad.pipeline.parameters import declared

# what a format can read, by the name of its parameter: files of the folder of a dataset
SOURCES = {
    "objects": "objects.parquet",
    "meshes": "rescaled/{gripper}",
    "scales": "rescaled/{gripper}/scales.parquet",
    "grasps": "grasps/{gripper}.parquet",
    "simulated_grasps": "grasps/{gripper}.parquet",  # the same table; it must have these labels
    "images": "images/{gripper}",
}


def formats() -> list[str]:
    """The names of all formats; none of their modules is imported."""
    return sorted(path.stem for path in Path(__file__).parent.glob("[!_]*.py"))


if TYPE_CHECKING:
    Format = str
else:
    Format = Literal[tuple(formats())]


def export_function(name: str) -> Callable[..., Any]:
    """The function that writes a format."""
    found: Callable[..., Any] = importlib.import_module(f"egad.pipeline.exports.{name}").run
    return found


def sources(name: str, gripper: str) -> dict[str, str]:
    """The files in the folder of a dataset that a format reads, by parameter."""
    names = [each.name for each in declared(export_function(name))]
    return {each: SOURCES[each].format(gripper=gripper) for each in names if each in SOURCES}
