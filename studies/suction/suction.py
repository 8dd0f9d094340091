"""Where a suction cup holds, and what its limits do (README.md).

    python studies/suction/suction.py picture
    python studies/suction/suction.py table
    python studies/suction/suction.py trials [--attempts N] [--rounds N]
    python studies/suction/suction.py film
    python studies/suction/suction.py evolved [--archive FILE]

`picture` draws three shapes, colored by the robust quality of a 30 mm cup, into docs/suction.png.
`table` labels 100 grasps of each object of the released evaluation set, with the bending limit of
the paper as it stands and with the tolerance, and compares the CPU time with antipodal grasps.
`trials` lets detectors try these objects with that cup in both engines, each alone and on tables
of several. `film` draws a cup that lifts an object into docs/suction_lift.png. `evolved` draws the
easiest and the hardest objects of an archive that was evolved for a cup into
evolved.png beside this file.
"""

import argparse
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pandas as pd
import trimesh
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import egad
from egad._util.arrays import Floats, RgbImage
from egad._util.files import atomic_output
from egad.bench import TrialProtocol, TrialRunner
from egad.detectors.suction import suction_depth
from egad.errors import RejectedError
from egad.geometry import Bundle, Material, RayCaster, mass_properties
from egad.grasps import RobustSuction
from egad.grasps.suction import collision_free, robust_suction_quality, sample_suction, seal_cups
from egad.grippers import SuctionCup
from egad.report.colors import COLOR_MAP, UNKNOWN
from egad.sim import ARMS, FAST_ENGINES, Film, build, open_world
from egad.sim.film import draw

FOLDER = Path(__file__).parent
DOCS = FOLDER.parents[1] / "docs"
GRIPPER = "cup_30mm"
CUP = SuctionCup()
MAX_SEEDS, LIFT_FRAMES = 20, 70
EDGE = 0.003  # metres: longest side of a colored triangle
DISTANCE, YAW, PITCH = 1.95, 35.0, -32.0  # diagonals of the box; degrees
FACING = 0.6  # cosine between the view and the approach of the grasp that is drawn
ARCHIVE = Path("results/egad/archive.parquet")
PARTS, SHOWN = (0.0, 1.8, 2.8, 6.0), 3  # limits of complexity, and objects of each part
CROP = (slice(10, -10), slice(20, -20))
WEIGHT = 9.81 * 400  # of a cubic metre, newtons
BINS = 26  # the copies of a grasp can hold 0 to 25 times


def main() -> None:
    """Draw or count."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    commands = {
        "picture": lambda _: draw_shapes(),
        "table": lambda _: print_table(),
        "trials": lambda given: print_trials(given.attempts, given.rounds),
        "film": lambda _: draw_lift(),
        "evolved": lambda given: draw_evolved(given.archive),
    }
    parser.add_argument("command", choices=list(commands))
    parser.add_argument("--archive", type=Path, default=ARCHIVE, help="of evolved objects")
    parser.add_argument("--attempts", type=int, default=10, help="at each object")
    parser.add_argument("--rounds", type=int, default=20, help="of each kind of scene")
    given = parser.parse_args()
    commands[given.command](given)


def mug() -> trimesh.Trimesh:
    """A mug, 80 mm across, with a handle."""
    wall = trimesh.creation.cylinder(0.04, 0.09, sections=96)
    room = trimesh.creation.cylinder(0.036, 0.09, sections=96).apply_translation([0, 0, 0.005])
    handle = trimesh.creation.torus(0.025, 0.006, major_sections=64, minor_sections=32)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([0.045, 0, 0])
    outside = trimesh.boolean.union([wall, handle], engine="manifold")
    return trimesh.boolean.difference([outside, room], engine="manifold")


def draw_shapes() -> None:
    """Draw a box, a mug and an evolved object into docs/suction.png."""
    evolved, _ = egad.rescale(egad.load("evaluation-set")["C2"].mesh, "panda")
    shapes = {"box": trimesh.creation.box([0.08, 0.06, 0.05]), "mug": mug(), "object C2": evolved}
    figure = Figure(figsize=(10, 2.9), layout="constrained")
    axes = figure.subplots(1, 3)
    for each, (name, mesh) in zip(axes, shapes.items(), strict=True):
        each.imshow(picture(mesh))
        each.set_title(name)
        each.axis("off")
    scale = ScalarMappable(cmap=COLOR_MAP)
    scale.set_clim(0, 1)
    figure.colorbar(scale, ax=axes, label="robust quality", shrink=0.8)
    with atomic_output(DOCS / "suction.png") as out:
        figure.savefig(out, format="png", dpi=100)


def picture(mesh: trimesh.Trimesh) -> RgbImage:
    """A shape with each small triangle in the color of its grasp, gray where the cup collides.

    A ring as large as that of the cup shows the best grasp on the side that is seen.
    """
    fine = trimesh.Trimesh(
        *trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, EDGE), process=False
    )
    origins, frames = poses(fine)
    quality, free = rate(mesh, origins, frames)
    number = np.where(free, np.round(quality * (BINS - 1)), BINS)
    colors = [to_rgb(colormaps[COLOR_MAP](k / (BINS - 1))) for k in range(BINS)]
    bodies = [
        (fine.submesh([np.flatnonzero(number == k)], append=True), color)
        for k, color in enumerate([*colors, to_rgb(UNKNOWN)])
        if (number == k).any()
    ]
    forward = Rotation.from_euler("ZX", [YAW, PITCH], degrees=True).as_matrix()[:, 1]
    facing = frames[:, 2] @ forward
    best = np.lexsort([facing, quality * free * (facing > FACING)])[-1]
    ring = trimesh.creation.torus(CUP.radius, 0.0007)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = frames[best].T, origins[best]
    bodies.append((ring.apply_transform(pose), to_rgb("#d55e00")))
    camera = DISTANCE * float(np.linalg.norm(mesh.extents)), YAW, PITCH
    return draw(bodies, np.asarray(mesh.bounds).mean(axis=0), camera)[CROP]


def poses(mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """Cups on the middles of all triangles."""
    z = -np.asarray(mesh.face_normals)
    side = np.diff(mesh.triangles[:, :2], axis=1)[:, 0]
    x = side / np.linalg.norm(side, axis=1, keepdims=True)
    return np.asarray(mesh.triangles_center), np.stack([x, np.cross(z, x), z], axis=1)


def rate(mesh: trimesh.Trimesh, origins: Floats, frames: Floats) -> tuple[Floats, Floats]:
    """Robust quality of cups on a mesh, and whether they are free of collisions."""
    caster, solid = RayCaster(mesh), mass_properties(mesh, WEIGHT)
    parts = np.array_split(np.arange(len(origins)), len(origins) // 1000 + 1)
    quality = [
        robust_suction_quality(
            caster,
            CUP,
            origins[part],
            frames[part],
            solid.com,
            solid.mass * frames[part, 2],
            robust=RobustSuction(),
            seed=0,
            indices=part,
        )
        for part in parts
    ]
    depths = seal_cups(caster, CUP, origins, frames).depths
    return np.concatenate(quality), collision_free(caster, CUP, origins, frames, depths)


def print_table() -> None:
    """Print what seals and holds, for two cups and two tolerances, and the CPU time."""
    meshes = [egad.rescale(each.mesh, "panda")[0] for each in egad.load("evaluation-set")]
    start = time.process_time()
    for mesh in meshes:
        egad.sample_grasps(mesh, "panda", n=100)
    print(f"antipodal: {time.process_time() - start:.2f} s")
    print("| cup, mm | tolerance, N m | objects | sealed | hold | quality >= 0.2 | CPU, s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for radius in (0.0075, 0.015):
        for tolerance in (0.0, CUP.torque_tolerance):
            cup = SuctionCup(radius=radius, height=2 * radius, torque_tolerance=tolerance)
            print_row(cup, meshes)


def print_row(cup: SuctionCup, meshes: list[trimesh.Trimesh]) -> None:
    """Print the row of a cup."""
    shares, sealing, start = [], 0, time.process_time()
    for mesh in meshes:
        try:
            found = sample_suction(mesh, cup, 100)
        except RejectedError:
            shares.append([0.0, 0.0, 0.0])
            continue
        sealing += 1
        good = found["quality"] >= 0.2
        shares.append([float(part.mean()) for part in (found["sealed"], found["resists"], good)])
    spent = time.process_time() - start
    sealed, hold, good = 100 * np.mean(shares, axis=0)
    size = f"{2000 * cup.radius:.0f} | {cup.torque_tolerance:g}"
    print(f"| {size} | {sealing} | {sealed:.1f} % | {hold:.1f} % | {good:.1f} % | {spent:.2f} |")


def print_trials(attempts: int, rounds: int) -> None:
    """Print success rates of detectors with the 30 mm cup: one object at a time, then tables."""
    objects = egad.load("evaluation-set")
    print("| detector | engine | success | no_grasp | no_seal | lost | collided |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for detector in ("labels", "suction-depth"):
        for engine in FAST_ENGINES:
            found = egad.run_trials(detector, objects, GRIPPER, attempts, engine=engine)
            counts = Counter(found.table["outcome"])
            lost = counts["slipped_lifting"] + counts["dropped"]
            rest = f"{counts['no_grasp']} | {counts['no_seal']} | {lost} | {counts['collided']}"
            print(f"| {detector} | {engine} | {found.success_rate()} | {rest} |", flush=True)
    print("| detector | engine | scene | success | cleared |")
    print("| --- | --- | --- | --- | --- |")
    for detector in ("labels", "suction-cloud"):
        for engine in FAST_ENGINES:
            cleared = egad.run_benchmark(
                detector, objects, GRIPPER, rounds=rounds, noise=("none",), engine=engine
            )
            for each in cleared.rates():
                rates = f"{each.success} | {each.cleared}"
                print(f"| {detector} | {engine} | {each.scene} | {rates} |", flush=True)


def draw_evolved(archive: Path) -> None:
    """Draw the easiest and the hardest objects of an archive into evolved.png beside this file."""
    objects = egad.load(archive)
    table = objects.table.sort_values(["graspability", "label"], ascending=[False, True])
    chosen = [
        table[table["complexity"].between(low, high, inclusive="left")]
        for low, high in pairwise(PARTS)
    ]
    columns = (len(PARTS) - 1) * SHOWN
    figure = Figure(figsize=(1.25 * columns, 3.2), layout="constrained")
    axes = figure.subplots(2, columns)
    for row, ends in enumerate(("head", "tail")):
        picked = pd.concat([getattr(part, ends)(SHOWN) for part in chosen])
        for each, (label, value) in zip(
            axes[row], picked[["label", "graspability"]].to_numpy(), strict=True
        ):
            each.imshow(egad.render(objects[label].mesh, 160))
            each.set_title(f"{value:.2f}", fontsize=9)
            each.axis("off")
    with atomic_output(FOLDER / "evolved.png") as out:
        figure.savefig(out, format="png", dpi=100)


def draw_lift() -> None:
    """Draw four moments of a lift of object C2 into docs/suction_lift.png."""
    gripper = egad.gripper(GRIPPER)
    mesh, _ = egad.rescale(egad.load("evaluation-set")["C2"].mesh, gripper)
    model, arm = build(mesh, Material().density, Bundle()), ARMS["axis"](gripper)
    with open_world("mujoco", [model], arm.robot) as world:
        runner, film = TrialRunner(world, arm, TrialProtocol()), Film(world)
        for seed in range(MAX_SEEDS):
            film.frames.clear()
            if runner.attempt(suction_depth, seed).outcome == "success":
                break
    lift = film.frames[-LIFT_FRAMES:]
    shown = [lift[round(share * (len(lift) - 1))] for share in (0.0, 0.12, 0.3, 0.45)]
    with atomic_output(DOCS / "suction_lift.png") as out:
        imageio.imwrite(out, np.concatenate(shown, axis=1), extension=".png")


if __name__ == "__main__":
    main()
