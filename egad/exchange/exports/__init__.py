"""Exports in the formats of other programs.

Formats of grasps and images are modules: each is a format with the same name. Its function `run`
reads what its parameters name (`SOURCES`) and writes the folder `out`. Formats of objects are those
of `egad.exchange`, and `_objects.py` writes them all. `egad export`, `targets.exports` and the rule
`export` know every format.
"""

import importlib
from collections.abc import Callable, Mapping
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args, get_type_hints

from egad._util.parameters import ParameterGroup
from egad.exchange import MeshFormat, PhysicsFormat

ObjectSet = Literal["evaluation-set", "all"]
EVALUATION_SET, ALL = get_args(ObjectSet)
OF_SURFACES = get_args(MeshFormat)
OF_OBJECTS = (*OF_SURFACES, *get_args(PhysicsFormat))

# what a format can read, by the name of its parameter: files of the folder of a dataset
SOURCES = {
    "objects": "objects.parquet",
    "meshes": "rescaled/{gripper}",
    "scales": "rescaled/{gripper}/scales.parquet",
    "grasps": "grasps/{gripper}.parquet",
    "simulated_grasps": "grasps/{gripper}.parquet",  # the same table; it must have these labels
    "images": "images/{gripper}",
    "bundle": "bundle/{gripper}",
    "convex_parts": "convex_parts/{gripper}.parquet",
}
# of folders, the file that is written last
LAST = {"meshes": "scales.parquet", "images": "card.md", "bundle": "bundle.parquet"}


def formats() -> list[str]:
    """The names of all formats; none of their modules is imported."""
    return sorted([*OF_OBJECTS, *(path.stem for path in Path(__file__).parent.glob("[!_]*.py"))])


if TYPE_CHECKING:
    Format = str
else:
    Format = Literal[tuple(formats())]


def export_module(name: str) -> str:
    """The module that writes a format."""
    return f"{__name__}.{'_objects' if name in OF_OBJECTS else name}"


def export_function(name: str, objects: ObjectSet = EVALUATION_SET) -> Callable[..., Any]:
    """The function that writes a format.

    Args:
        name: The format.
        objects: Which objects are written, for a format of objects.
    """
    module = importlib.import_module(export_module(name))
    if name in OF_OBJECTS:
        found: Callable[..., Any] = module.run_all if objects == ALL else module.run_evaluation_set
    else:
        found = module.run
    return found


def settings_class(name: str, objects: ObjectSet = EVALUATION_SET) -> type[ParameterGroup]:
    """The class of the settings that a format reads.

    Args:
        name: The format.
        objects: Which objects are written, for a format of objects.
    """
    found: type[ParameterGroup] = get_type_hints(export_function(name, objects))["settings"]
    return found


def sources(name: str, gripper: str, objects: ObjectSet = EVALUATION_SET) -> dict[str, str]:
    """The files in the folder of a dataset that a format reads, by parameter.

    Args:
        name: The format.
        gripper: The name of the gripper.
        objects: Which objects are written, for a format of objects.
    """
    names = signature(export_function(name, objects)).parameters
    unused = {"convex_parts"} if name in OF_SURFACES else set()
    return {
        each: SOURCES[each].format(gripper=gripper)
        for each in names
        if each in SOURCES.keys() - unused
    }


def last_files(name: str, gripper: str, objects: ObjectSet = EVALUATION_SET) -> list[str]:
    """The same as paths; for a folder, the file that is written last."""
    found = sources(name, gripper, objects)
    return [str(Path(path, LAST.get(each, ""))) for each, path in found.items()]


def write_format(
    name: str,
    objects: ObjectSet,
    settings: ParameterGroup,
    gripper: str,
    reads: Mapping[str, Path],
    out: Path,
) -> None:
    """Write a format.

    Args:
        name: The format.
        objects: Which objects are written, for a format of objects.
        settings: Of the class `settings_class`.
        gripper: The name of the gripper.
        reads: The files of `sources`.
        out: File or folder to write.
    """
    write = export_function(name, objects)
    known = {"settings": settings, "gripper": gripper, "style": name, "out": out, **reads}
    known.setdefault("convex_parts", None)
    write(**{each: known[each] for each in signature(write).parameters})
