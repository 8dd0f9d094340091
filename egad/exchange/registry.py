"""The formats of other programs, each a module with its name in the folder of its kind.

- `objects/NAME.py`: `write(folder, name, made, friction)` writes one object into an existing
  folder. `made` is an `egad.geometry.SimulationObject`: mesh, convex parts, mass and stable poses.
- `images/NAME.py`: `write(pictures, gripper, folder)` writes rendered images into an empty folder
  and returns how many; it raises UserError if they do not fit the format.
- `grasps/NAME.py`: `run(settings, ..., out)` writes the grasps of a run, and makes `out`. Its
  parameters name what it reads: `gripper`, the name, and files of `SOURCES`. The annotation of
  `settings` is the class of the settings that it needs; each such class has a `gripper`.
  `write(folder, label, made, grasps, hand)`, if there is one, writes one object, `made` as above,
  with its simulated grasps for `egad.export`. With `KIND = "cup"`, it is for suction cups, whose
  grasps are labelled but not simulated; the others are for jaws.

- `grasps/NAME.py` and `readers/NAME.py`: `read(content, options)` returns the
  `egad.exchange.grasp_files.FileGrasps` of what a file holds. `KEYS` are names by which a file is
  recognised, `a.b` for one within another. `READERS` has the endings of the files:
  `egad.read_grasps` then knows the format.

A module may have `check(hand)`, called first, which raises an error if the format cannot be
written. Surfaces are mesh files, which `egad.io` writes. `egad.export`, the command `egad export`,
`targets.exports` and the rule `export` know every format.
"""

import importlib
from collections.abc import Callable, Mapping
from functools import partial
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_type_hints

from egad._util.extras import needed_for
from egad._util.parameters import ParameterGroup
from egad.errors import UserError
from egad.exchange.parameters import NamedGripper
from egad.grippers.kinds import JawKind

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
LAST_FILE = {"meshes": "scales.parquet", "images": "card.md", "bundle": "bundle.parquet"}


def _modules(kind: str) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in (Path(__file__).parent / kind).glob("[!_]*.py")))


# The endings of the files of grasps that are read.
READERS = {
    "acronym": (".h5",),
    "contact_graspnet": (".npz",),
    "dexnet": (".hdf5", ".h5"),
    "graspgen": (".json", ".yaml", ".yml"),
    "graspgen_suction": (".json",),
    "graspnet": (".npy", ".npz"),
    "isaac_grasp": (".yaml", ".yml"),
    "poses": (".npz", ".npy", ".csv"),
    "simready": (".usd", ".usda", ".usdc"),
    "vgn": (".csv",),
}
SURFACES = ("glb", "obj", "stl")  # the endings of `egad.io.WRITERS`, which takes long to import
OBJECTS, GRASPS, IMAGES = (_modules(kind) for kind in ("objects", "grasps", "images"))
OBJECT_FORMATS = (*SURFACES, *OBJECTS)
FORMATS = tuple(sorted([*OBJECT_FORMATS, *GRASPS, *IMAGES]))
MODULES = {
    **dict.fromkeys(SURFACES, "egad.exchange.surfaces"),
    **{name: f"egad.exchange.objects.{name}" for name in OBJECTS},
    **{name: f"egad.exchange.grasps.{name}" for name in GRASPS},
    **{name: f"egad.exchange.images.{name}" for name in IMAGES},
}
if TYPE_CHECKING:
    Format = str
    ObjectFormat = str
else:
    Format, ObjectFormat = Literal[FORMATS], Literal[OBJECTS]


def module_of(name: str) -> ModuleType:
    """The module that writes a format; MissingPackageError if it needs another package."""
    with needed_for(name):
        return importlib.import_module(MODULES[name])


def reader_of(name: str) -> ModuleType:
    """The module that reads a format of grasps; MissingPackageError if a package is missing."""
    with needed_for(name):
        return importlib.import_module(
            MODULES[name] if name in GRASPS else f"{__package__}.readers.{name}"
        )


def modules_of_format(name: str) -> list[str]:
    """The modules whose code decides what a format writes."""
    return [MODULES[name], *([] if name in GRASPS else [f"{__package__}.whole_sets"])]


def check_format(name: str, hand: NamedGripper) -> None:
    """Raise UserError if a package is missing, or the gripper lacks what a format describes."""
    module = module_of(name)
    kind = hand.gripper.kind
    if name in (*GRASPS, *IMAGES) and kind.name != kind_of_format(name):
        fitting = [each for each in (*GRASPS, *IMAGES) if kind_of_format(each) == kind.name]
        raise UserError(
            f"format {name!r} is not for {hand.name}, which has {kind.noun}; allowed: "
            f"{', '.join(sorted([*OBJECT_FORMATS, *fitting]))}"
        )
    if check := getattr(module, "check", None):
        check(hand)


def kind_of_format(name: str) -> str:
    """The kind of grippers whose grasps a format holds: the module's `KIND`, or jaws."""
    return getattr(module_of(name), "KIND", JawKind.name) if name in GRASPS else JawKind.name


def needs_run(name: str) -> bool:
    """Whether a format needs the results of a run; MissingPackageError if a package is missing."""
    return name in IMAGES or (name in GRASPS and not hasattr(module_of(name), "write"))


def writer_of(name: str) -> Callable[..., Any]:
    """The function that writes one object in a format of objects, as in `objects/NAME.py`."""
    write: Callable[..., Any] = module_of(name).write
    return partial(write, ending=name) if name in SURFACES else write


def export_function(name: str, objects: ObjectSet = EVALUATION_SET) -> Callable[..., Any]:
    """The function that writes a format from the results of a run."""
    if name in GRASPS:
        found: Callable[..., Any] = module_of(name).run
        return found
    loops = importlib.import_module(f"{__package__}.whole_sets")
    if name in IMAGES:
        found = loops.write_images
    elif objects == EVALUATION_SET:
        found = loops.write_evaluation_set
    else:
        found = loops.write_all_surfaces if name in SURFACES else loops.write_all
    return found


def settings_class(name: str, objects: ObjectSet = EVALUATION_SET) -> type[ParameterGroup]:
    """The class of the settings that a format reads; `objects` counts for formats of objects."""
    found: type[ParameterGroup] = get_type_hints(export_function(name, objects))["settings"]
    return found


def sources(name: str, gripper: str, objects: ObjectSet = EVALUATION_SET) -> dict[str, str]:
    """The files that a format reads from the folder of a dataset, by parameter."""
    names = signature(export_function(name, objects)).parameters
    return {each: SOURCES[each].format(gripper=gripper) for each in names if each in SOURCES}


def last_files(name: str, gripper: str, objects: ObjectSet = EVALUATION_SET) -> list[str]:
    """The same as paths; for a folder, the file that is written last."""
    found = sources(name, gripper, objects)
    return [str(Path(path, LAST_FILE.get(each, ""))) for each, path in found.items()]


def write_format(
    name: str,
    objects: ObjectSet,
    settings: Any,  # noqa: ANN401 (of the class that the format has)
    gripper: str,
    reads: Mapping[str, Path],
    out: Path,
) -> None:
    """Write a format from the files of `sources`, with settings of its `settings_class`."""
    check_format(name, NamedGripper(gripper, settings.gripper))
    known = {"settings": settings, "gripper": gripper, "ending": name, "out": out, **reads}
    if name in OBJECT_FORMATS:
        known["write"] = writer_of(name)
    elif name in IMAGES:
        known["write"] = module_of(name).write
    export = export_function(name, objects)
    export(**{each: known[each] for each in signature(export).parameters})
