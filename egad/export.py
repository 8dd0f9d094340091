"""Objects with sampled grasps in the formats of other programs, from Python.

Formats of objects are those of `egad/exchange/formats.py`, which the command `egad export` has too.
Its formats of grasps and images are in `egad/exchange/exports/`: they read results.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.display import facts_html
from egad._util.files import as_path, atomic_output, check_empty
from egad._util.parameters import SCALE_RULES, check_count
from egad._util.progress import progress
from egad.api import dataset_grasps
from egad.errors import RejectedError, check_name
from egad.evalset import Bundle, make_simulation_object
from egad.exchange import (
    MESH_WRITERS,
    PHYSICS_WRITERS,
    Acronym,
    Body,
    Jaws,
    check_articulated,
    check_installed,
    check_key,
    graspgen_hand,
    start_graspgen,
    write_acronym,
    write_graspgen,
    write_graspnet,
    write_isaac_grasp,
    write_obj,
)
from egad.geometry import Material, mass_properties
from egad.grasps import FRICTION, LabelParameters, label_parameters
from egad.grippers import Gripper, as_gripper, finger_span
from egad.named_meshes import NamedMesh, named_meshes, scaled_solid
from egad.objects import Dataset
from egad.sim import (
    EngineName,
    Lifting,
    SimulatedLabel,
    SimulatedLabelParameters,
    build,
    check_engine,
    simulate_labels,
)


class _Job(NamedTuple):
    """What is exported for: the name of the gripper, and how grasps are labelled and simulated."""

    gripper: str
    labels: LabelParameters
    simulation: SimulatedLabelParameters


@dataclass(frozen=True, repr=False)
class Exported:
    """What `export` wrote.

    Attributes:
        folder: Where it is.
        labels: The objects that were written.
        left_out: Why other objects were not, by label.
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
        """Where it is, and what was left out, for notebooks."""
        facts = {"exported": len(self.labels)} | {
            f"left out: {label}": reason for label, reason in self.left_out.items()
        }
        return facts_html(str(self.folder), facts)

    @property
    def files(self) -> list[Path]:
        """All files in the folder and below it, in alphabetical order."""
        return sorted(path for path in self.folder.rglob("*") if path.is_file())


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
            `graspgen`: a dataset of GraspGen, with `objects/LABEL.obj`. `graspnet`: `LABEL.npy` for
            graspnetAPI, and `meshes/LABEL.obj`. `isaac_grasp`: `LABEL.yaml`, for a gripper with a
            file, and `meshes/LABEL.obj`. Without grasps: `usd`, `sdf`, `urdf`, `mjcf`,
            `robosuite`: for each object a folder with its surface, convex parts, mass, friction and
            stable poses. `simulation`: URDF and MJCF in one folder. `vgn`: URDF files side by side,
            for the simulator of VGN. `glb`: surfaces with a material, for browsers and Blender.
            `obj`: surfaces in metres. `stl`: surfaces in millimetres, to print. See
            `docs/exchange.md`.
        gripper: The gripper, or its name.
        out: A new or empty folder.
        grasps: Most grasps of an object, 100 as in a dataset of the pipeline; formats without
            grasps ignore this, `seed` and `engine`.
        seed: Of the grasps. They are those that a dataset of the pipeline has with the same seed.
        rule: How objects are scaled: see `egad.rescale`.
        engine: What simulates the grasps: `mujoco` or `pybullet`.

    Returns:
        What was written, and which objects were left out for which reason: their mesh does not
        bound a solid, or they cannot be scaled, grasped or decomposed.

    Raises:
        UserError: There is no such format, gripper or rule, there are no objects, a name or number
            is not allowed, the folder is not empty, a mesh file of the dataset is missing, or the
            format needs a package that is not installed.

    Warns:
        UnitsWarning: The size of a mesh suggests another unit than the metre.
        PartsWarning: An object needs more convex parts than are allowed.
    """
    write = _writer(check_name("format", format, FORMATS))
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
    job = _Job(gripper if isinstance(gripper, str) else "gripper", labels, simulation)
    items, left_out = named_meshes(objects), dict[str, str]()
    for item in items:
        check_key(item.label)
    target = as_path("out", out)
    check_empty(target)
    with atomic_output(target, keep=False) as folder:
        folder.mkdir()
        for item in progress(items, "exporting", len(items)):
            try:
                write(folder, item, scaled_solid(item, hand, rule), job)
            except RejectedError as reason:
                left_out[item.label] = str(reason)
    written = [item.label for item in items if item.label not in left_out]
    return Exported(target, written, left_out)


def _acronym(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh, job: _Job) -> None:
    file = f"meshes/{item.label}.obj"
    mass = mass_properties(mesh, Material().density)
    grasps = _simulated(item, mesh, job)
    write_obj(mesh, folder / file)
    body = Body(
        file=file,
        scale=1.0,
        volume=mass.volume,
        mass=mass.mass,
        com=np.asarray(mass.com),
        inertia=mass.inertia,
        friction=FRICTION,
    )
    hand = job.labels.gripper
    jaws = Jaws(job.gripper, hand.opening, finger_span(hand)[1])
    write_acronym(
        folder / f"{item.label}.h5", body, jaws, grasps, Acronym().min_robust_success_rate
    )


def _graspgen(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh, job: _Job) -> None:
    hand = graspgen_hand(job.gripper, job.labels.gripper)
    grasps = _simulated(item, mesh, job)
    if not (folder / "objects").exists():
        start_graspgen(folder, hand)
    write_obj(mesh, folder / "objects" / f"{item.label}.obj")
    write_graspgen(folder, hand, item.label, grasps)


def _isaac_grasp(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh, job: _Job) -> None:
    hand = job.labels.gripper
    check_articulated(job.gripper, hand)
    write_isaac_grasp(folder / f"{item.label}.yaml", item.label, hand, _simulated(item, mesh, job))
    write_obj(mesh, folder / f"meshes/{item.label}.obj")


def _graspnet(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh, job: _Job) -> None:
    grasps = _simulated(item, mesh, job)
    write_graspnet(folder, item.label, grasps, job.labels.gripper.opening)
    write_obj(mesh, folder / f"meshes/{item.label}.obj")


def _simulated(item: NamedMesh, mesh: trimesh.Trimesh, job: _Job) -> pd.DataFrame:
    """Sampled grasps of an object with simulated labels."""
    labelled = dataset_grasps(mesh, item.id, job.labels)
    model = build(mesh, Material().density, Bundle(), item.label)
    return simulate_labels(model, labelled, job.simulation)


def _writer(name: str) -> "Writer":
    """What writes an object in a format, alike for all formats."""
    if name in GRASP_WRITERS:
        return GRASP_WRITERS[name]
    check_installed(name)

    def write(folder: Path, item: NamedMesh, mesh: trimesh.Trimesh, _job: _Job) -> None:
        if name in MESH_WRITERS:
            MESH_WRITERS[name](folder, item.label, mesh)
        else:
            made = make_simulation_object(mesh, Material().density, Bundle(), item.label)
            PHYSICS_WRITERS[name](folder, item.label, made, Bundle().friction)

    return write


Writer = Callable[[Path, NamedMesh, trimesh.Trimesh, _Job], None]
GRASP_WRITERS: dict[str, Writer] = {
    "acronym": _acronym,
    "graspgen": _graspgen,
    "graspnet": _graspnet,
    "isaac_grasp": _isaac_grasp,
}
FORMATS = (*GRASP_WRITERS, *MESH_WRITERS, *PHYSICS_WRITERS)
