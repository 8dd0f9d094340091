"""Objects with sampled grasps in the formats of other programs, from Python.

The formats are those of `egad.exchange` that do not need the results of a run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from egad._util.display import facts_html
from egad._util.files import as_path
from egad._util.parameters import SCALE_RULES, check_count
from egad._util.progress import progress
from egad.errors import RejectedError, UserError, check_name
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import NamedGripper
from egad.exchange.registry import (
    FORMATS,
    GRASPS,
    OBJECTS,
    SURFACES,
    check_format,
    module_of,
    needs_run,
    writer_of,
)
from egad.geometry import Bundle, Material
from egad.grasps import Grasps, LabelParameters, label_parameters
from egad.grasps.sampling import dataset_grasps
from egad.grippers import Gripper, as_gripper
from egad.io import files_below, write_mesh
from egad.objects import Dataset, NamedMesh, named_meshes, scaled_solid
from egad.sim import (
    EngineName,
    Lifting,
    SimulatedLabel,
    SimulatedLabelParameters,
    check_engine,
    make_simulation_object,
    model_of,
    simulate_labels,
)
from egad.tables.grasping import MOTIONS
from egad.tables.outcomes import Outcome


@dataclass(frozen=True, repr=False)
class Exported:
    """What `export` wrote.

    Attributes:
        folder: Where it is.
        labels: The objects that were written.
        left_out: Why the other objects were left out, by label.
    """

    folder: Path
    labels: list[str]
    left_out: dict[str, str]

    def __repr__(self) -> str:
        missing = "; ".join(f"{label}: {reason}" for label, reason in self.left_out.items())
        return f"{self.folder}: {len(self.labels)} exported" + (
            f"; left out: {missing}" if missing else ""
        )

    def _repr_html_(self) -> str:
        facts = {"exported": len(self.labels)} | {
            f"left out: {label}": reason for label, reason in self.left_out.items()
        }
        return facts_html(str(self.folder), facts)

    @property
    def files(self) -> list[Path]:
        """All files in the folder and below it, in alphabetical order."""
        return sorted(files_below(self.folder))


def export(
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    format: str,  # noqa: A002 (what users call it)
    gripper: Gripper | str,
    out: str | Path,
    *,
    grasps: int = 100,
    seed: int = 0,
    rule: str = "paper",
    engine: EngineName = "mujoco",
) -> Exported:
    """Write objects, scaled to a gripper, in the format of another program.

    Args:
        objects: A dataset, or meshes in metres by name.
        format: With sampled and simulated grasps: `acronym`: `LABEL.h5`, and `meshes/LABEL.obj`.
            `graspgen`: a dataset of GraspGen, with `objects/LABEL.obj`; `graspgen_suction`: the
            same for a suction cup, not simulated. `graspnet`: `LABEL.npy` for
            graspnetAPI, and `meshes/LABEL.obj`. `isaac_grasp`: `LABEL.yaml`, for a gripper with a
            file, and `meshes/LABEL.obj`. `simready`: `LABEL/simready/LABEL.usd`, with the grasps
            that succeeded. Without grasps: `usd`, `sdf`, `urdf`, `mjcf`,
            `robosuite`: for each object a folder with its surface, convex parts, mass, friction and
            stable poses. `simulation`: URDF and MJCF in one folder. `vgn`: URDF files side by side,
            for the simulator of VGN. `glb`: surfaces with a material, for browsers and Blender.
            `obj`: surfaces in metres. `stl`: surfaces in millimetres, to print. See
            `docs/exchange.md`.
        gripper: The gripper, or its name.
        out: A new or empty folder.
        grasps: Largest number of grasps of an object; 100, as in a dataset of the pipeline. Formats
            without grasps ignore this, `seed` and `engine`.
        seed: Seed of the grasps; with the same one, a dataset of the pipeline has the same grasps.
        rule: How objects are scaled: see `egad.rescale`.
        engine: What simulates the grasps: `mujoco`, `pybullet` or `drake`.

    Returns:
        What was written, and which objects were left out and why: their mesh does not bound a
        solid, or they cannot be scaled, grasped or decomposed.

    Raises:
        UserError: There is no such format, gripper or rule, there are no objects, a name or number
            is not allowed, the folder is not empty, a mesh file of the dataset is missing, or the
            format needs a package that is not installed.

    Warns:
        UnitsWarning: The size of a mesh suggests a unit other than the metre.
        PartsWarning: An object needs more convex parts than are allowed.
    """
    check_name("format", format, FORMATS)
    if needs_run(format):
        raise UserError(
            f"format {format!r} is written from the results of a run: see `egad export --help`"
        )
    check_name("rule", rule, SCALE_RULES)
    check_engine(engine)
    hand = as_gripper(gripper)
    labels = label_parameters(hand, check_count("grasps", grasps), seed)
    simulation = SimulatedLabelParameters(
        gripper=hand,
        quality=labels.quality,
        trials=Lifting(),
        simulated_label=SimulatedLabel(engine=engine, grasps=grasps),
    )
    named = NamedGripper(gripper if isinstance(gripper, str) else "gripper", hand)
    check_format(format, named)
    write = _writer(format, named, labels, simulation)
    items, left_out = named_meshes(objects), dict[str, str]()
    for item in items:
        check_key(item.label)
    target = as_path("out", out)
    with new_folder(target) as folder:
        for item in progress(items, "exporting", len(items)):
            try:
                write(folder, item, scaled_solid(item, hand, rule))
            except RejectedError as reason:
                left_out[item.label] = str(reason)
    written = [item.label for item in items if item.label not in left_out]
    return Exported(target, written, left_out)


def export_grasps(
    grasps: Grasps, mesh: trimesh.Trimesh, name: str, gripper: Gripper | str, out: Path, label: str
) -> None:
    """Write grasps that were read with this mesh, and the labels of their file; `UserError`."""
    named = NamedGripper(gripper if isinstance(gripper, str) else "gripper", as_gripper(gripper))
    check_name("format", name, [each for each in GRASPS if not needs_run(each)])
    check_format(name, named)
    if np.isnan(grasps.source_success).any():
        raise UserError(f"{name} needs the label of each grasp; some have none")
    success = grasps.source_success == 1
    outcomes = np.where(success, Outcome.SUCCESS, Outcome.SLIPPED_SHAKING)
    about = {"simulated_outcome": outcomes, "simulated_success": success, "simulated_engine": ""}
    table = grasps.to_frame().assign(**about, **dict.fromkeys(MOTIONS, np.nan))
    made = make_simulation_object(mesh, Material().density, Bundle(), check_key(label))
    with new_folder(out) as folder:
        module_of(name).write(folder, label, made, table, named)


def _writer(
    name: str, hand: NamedGripper, labels: LabelParameters, simulation: SimulatedLabelParameters
) -> Callable[[Path, NamedMesh, trimesh.Trimesh], None]:
    """The function that writes an object in a format, with the same arguments for all formats."""
    bundle, density = Bundle(), Material().density

    def write_surface(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh) -> None:
        write_mesh(mesh, folder / f"{item.label}.{name}")

    def write_object(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh) -> None:
        made = make_simulation_object(mesh, density, bundle, item.label)
        writer_of(name)(folder, item.label, made, bundle.friction)

    def write_grasps(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh) -> None:
        grasps = dataset_grasps(mesh, item.id, labels)
        made = make_simulation_object(mesh, density, bundle, item.label)
        if hand.gripper.kind.closes:
            model = model_of(made.mesh, made.parts, made.physics, made.volume_error)
            grasps = simulate_labels(model, grasps, simulation)
        module_of(name).write(folder, item.label, made, grasps, hand)

    if name in SURFACES:
        return write_surface
    return write_object if name in OBJECTS else write_grasps
