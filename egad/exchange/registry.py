"""The formats of other programs, each a module with its name in the folder of its kind.

- `objects/NAME.py`: `write(folder, name, made, friction)` writes an object with its convex parts.
- `grasps/NAME.py`: `run(settings, ..., out)` writes the grasps of a run; its parameters name what
  it reads (`SOURCES`). `write(folder, label, mesh, grasps, hand)`, if it has one, writes one object
  with its simulated grasps for `egad.export`.
- `images/NAME.py`: `write(pictures, gripper, folder)` writes rendered images.

A module may have `check(hand)`, which raises an error if the format cannot be written. Surfaces are
mesh files, which `egad.io` writes. `egad.export`, the command `egad export`, `targets.exports` and
the rule `export` know every format.
"""

import importlib
from collections.abc import Callable, Mapping
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_type_hints

from egad._util.extras import needed_for
from egad._util.parameters import ParameterGroup
from egad.exchange.parameters import NamedGripper

ObjectSet = Literal["evaluation-set", "all"]
EVALUATION_SET, ALL = get_args(ObjectSet)

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


def _modules(kind: str) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in (Path(__file__).parent / kind).glob("[!_]*.py")))


SURFACES = ("glb", "obj", "stl")  # the endings of `egad.io.WRITERS`, which takes long to import
OBJECTS, GRASPS, IMAGES = (_modules(kind) for kind in ("objects", "grasps", "images"))
OF_OBJECTS = (*SURFACES, *OBJECTS)
FORMATS = tuple(sorted([*OF_OBJECTS, *GRASPS, *IMAGES]))
if TYPE_CHECKING:
    Format = str
    ObjectFormat = str
else:
    Format, ObjectFormat = Literal[FORMATS], Literal[OBJECTS]


def module_name(name: str) -> str:
    """The module that writes a format."""
    kinds = {"objects": OBJECTS, "grasps": GRASPS, "images": IMAGES}
    found = [f"egad.exchange.{kind}.{name}" for kind, names in kinds.items() if name in names]
    return found[0] if found else "egad.io.mesh"


def module_of(name: str) -> ModuleType:
    """The same, imported.

    Raises:
        MissingPackageError: A package that it needs is not installed.
    """
    with needed_for(name):
        return importlib.import_module(module_name(name))


def check_format(name: str, hand: NamedGripper) -> None:
    """Check that a format can be written for a gripper.

    Raises:
        UserError: A package is not installed, or the gripper lacks what the format describes.
    """
    if check := getattr(module_of(name), "check", None):
        check(hand)


def export_function(name: str, objects: ObjectSet = EVALUATION_SET) -> Callable[..., Any]:
    """The function that writes a format from the results of a run.

    Args:
        name: The format.
        objects: Which objects are written, for a format of objects.
    """
    from egad.exchange import whole_sets  # noqa: PLC0415 (commands list the formats without it)

    if name in IMAGES:
        return whole_sets.write_images
    whole = objects == ALL
    if name in SURFACES:
        return whole_sets.write_all_surfaces if whole else whole_sets.write_evaluation_surfaces
    if name in OBJECTS:
        return whole_sets.write_all if whole else whole_sets.write_evaluation_set
    found: Callable[..., Any] = module_of(name).run
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
    return {each: SOURCES[each].format(gripper=gripper) for each in names if each in SOURCES}


def last_files(name: str, gripper: str, objects: ObjectSet = EVALUATION_SET) -> list[str]:
    """The same as paths; for a folder, the file that is written last."""
    found = sources(name, gripper, objects)
    return [str(Path(path, LAST.get(each, ""))) for each, path in found.items()]


def write_format(
    name: str,
    objects: ObjectSet,
    settings: Any,  # noqa: ANN401 (of the class that the format has)
    gripper: str,
    reads: Mapping[str, Path],
    out: Path,
) -> None:
    """Write a format from the results of a run.

    Args:
        name: The format.
        objects: Which objects are written, for a format of objects.
        settings: Settings, of the class that `settings_class` gives.
        gripper: The name of the gripper.
        reads: The files of `sources`.
        out: File or folder to write.
    """
    check_format(name, NamedGripper(gripper, settings.gripper))
    known = {"settings": settings, "gripper": gripper, "out": out, "ending": f".{name}", **reads}
    if name in (*OBJECTS, *IMAGES):
        known["write"] = module_of(name).write
    write = export_function(name, objects)
    write(**{each: known[each] for each in signature(write).parameters})
