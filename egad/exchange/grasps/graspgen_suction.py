"""GraspGen datasets for suction cups: JSON files of grasps, lists of objects, and the cup."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import by_object
from egad.exchange.grasps.graspgen import DESCRIPTION, add_object, start_dataset
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import GripperFormat, NamedGripper
from egad.geometry import RayCaster
from egad.grasps import Grasps
from egad.grasps.suction import HOLE_POINTS, seal_cups
from egad.grippers import SuctionCup, cup_of
from egad.io import read_mesh, write_obj
from egad.sim import SimulationObject
from egad.tables import parquet
from egad.tables.grasping import GRASPS

KEYS, KIND = ({"grasps.transforms", "grasps.suction_points"},), "cup"
STANDOFF = 0.001  # metres that GraspGen's cup stays above the surface
OUTWARDS = np.diag([1.0, -1.0, -1.0, 1.0])  # our z is the approach, theirs the outward normal
COLUMNS = [name for name in GRASPS.names if name not in ("id", "label")]
OF_CUP = """

def load_control_points():
    return torch.from_numpy(np.column_stack([LINE, np.ones(len(LINE))]).T).float()


def load_control_points_for_visualization():
    return [LINE]
"""


def suction_transforms(grasps: Grasps) -> Floats:
    """Poses in GraspGen's frame, (n, 4, 4): z is the outward normal, 1 mm above the surface."""
    poses: Floats = grasps.poses @ OUTWARDS
    poses[:, :3, 3] += STANDOFF * poses[:, :3, 2]
    return poses


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of a file, the middle of the ring on the mesh times `object.scale`; 0 wide."""
    grasps, depth = content["grasps"], options.depth
    if depth is None:
        cup = files.mapping(content.get("gripper", {}), "its gripper")
        depth = cup.get("standoff_distance", STANDOFF)
    return files.file_grasps(
        grasps["transforms"],
        files.hand_in_frame(options.frame or "x -z", depth),
        widths=0.0,
        success=np.asarray(grasps.get("object_in_gripper", np.nan), np.float64),
        score=grasps.get("score", np.nan),
    )


def described_cup(name: str, cup: SuctionCup) -> dict[str, Any]:
    """A cup described by GraspGen's keys."""
    return {
        "poses": [np.eye(4).tolist()],
        "num_sides": cup.sides,
        "radius": cup.radius,
        "height": cup.height,
        "suction_force": cup.vacuum_force,
        "material_kappa": cup.bending,
        "friction_mu": cup.friction,
        "interpolated_perimeter_vertices": 0,
        "spring_max_length_change": cup.max_strain,
        "standoff_distance": STANDOFF,
        "num_suction_points_for_hole_check": HOLE_POINTS,
        "collision_mesh_fname": f"{name}.obj",
    }


def start_suction(folder: Path, name: str, cup: SuctionCup) -> None:
    """Make the folders of a dataset, empty lists, and the description of the cup."""
    top = cup.height + cup.stem_length
    line = [[0.0, 0.0, height] for height in (0.0, cup.height, top)]
    about = described_cup(name, cup) | {"depth": top, "control_points": line}
    program = DESCRIPTION.format(kind="cup", points="LINE") + OF_CUP
    start_dataset(folder, name, about, program, _cup_mesh(cup))


def write_suction(
    folder: Path, name: str, cup: SuctionCup, label: str, mesh: trimesh.Trimesh, rows: pd.DataFrame
) -> None:
    """Write the grasps of an object, those that seal as in the gripper, and its name to a list.

    Grasps of other programs keep their label.
    """
    grasps = Grasps(rows)
    poses = grasps.poses
    frames = np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))
    sealed = seal_cups(RayCaster(mesh), cup, poses[:, :3, 3], frames).sealed
    held = np.asarray(rows.get("simulated_success", sealed & grasps.collision_free), dtype=bool)
    written = {
        "object": {"file": f"{label}.obj", "scale": 1.0},
        "gripper": described_cup(name, cup),
        "grasps": {
            "transforms": suction_transforms(grasps).round(9).tolist(),
            "suction_points": grasps.contacts[:, 0].round(9).tolist(),
            "approach_vectors": (-poses[:, :3, 2]).round(9).tolist(),
            "object_in_gripper": held.tolist(),
            "is_sealed": sealed.tolist(),
            "score": grasps.quality.tolist(),
        },
    }
    add_object(folder, name, label, written)


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Add an object to a dataset of GraspGen: see `egad.exchange.registry`."""
    cup = cup_of(hand.gripper, "graspgen_suction")
    if not (folder / "objects").exists():
        start_suction(folder, hand.name, cup)
    write_obj(made.mesh, folder / "objects" / f"{label}.obj")
    write_suction(folder, hand.name, cup, label, made.mesh, grasps)


def run(settings: GripperFormat, gripper: str, meshes: Path, grasps: Path, out: Path) -> None:
    """Write a dataset of GraspGen: grasps, meshes, lists of objects and the cup."""
    cup = cup_of(settings.gripper, "graspgen_suction")
    name = check_key(gripper, "gripper")
    with new_folder(out) as folder:
        start_suction(folder, name, cup)
        labels = parquet.distinct(grasps, "label")
        found = progress(by_object(grasps, COLUMNS), "writing grasps", len(labels))
        for label, rows in found:
            file = f"{check_key(label)}.obj"
            shutil.copyfile(meshes / file, folder / "objects" / file)
            write_suction(folder, name, cup, label, read_mesh(meshes / file, "m"), rows)


def _cup_mesh(cup: SuctionCup) -> trimesh.Trimesh:
    """Cup and stem, which stand on the ring and point outwards."""
    top = cup.height + cup.stem_length
    outline = [
        [0.0, 0.0],
        [cup.radius, 0.0],
        [cup.stem_radius, cup.height],
        [cup.stem_radius, top],
        [0.0, top],
    ]
    mesh: trimesh.Trimesh = trimesh.creation.revolve(np.array(outline), sections=32)
    return mesh
