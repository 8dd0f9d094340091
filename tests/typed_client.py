"""A program of a user that takes the whole public API; `mypy --strict` checks it."""

import warnings
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

import egad
from egad.detectors import Grasp, View


def highest_point(view: View, gripper: egad.Gripper, rng: np.random.Generator) -> list[Grasp]:
    """A grasp of the highest point that the camera sees."""
    del rng
    points = view.points()[view.heights() > 0.005]
    x, y, z = points[points[:, 2].argmax()].tolist()
    return [Grasp((x, y, z), 0.0, gripper.opening, min(0.02, z), 1.0)]


def bulk_and_length(mesh: trimesh.Trimesh) -> tuple[float, float]:
    """Two measures."""
    return float(mesh.volume), float(mesh.extents.max() / mesh.extents.min())


def use_objects(folder: Path) -> None:
    """Load, measure, compare, scale and grasp."""
    objects: egad.Dataset = egad.load("released")
    each: egad.EvolvedObject = objects["M14_3"]
    complex_ones: egad.Dataset = objects[objects.table["complexity"] > 4]
    two: egad.Dataset = objects[["M14_3", "E08_0"]]
    none: egad.Dataset = two[np.zeros(len(two), dtype=bool)]
    voxels: NDArray[np.bool_] = each.voxels
    panda: egad.Gripper = egad.gripper("panda")
    mesh, factor = egad.rescale(each.mesh, panda, "paper")
    found: egad.Measures = egad.measure(mesh, gripper=egad.Gripper(opening=0.11), seed=0)
    grasps: egad.Grasps = egad.sample_grasps(
        mesh, panda, n=20, seed=0, friction=0.6, cone=0.6, approach_angles=8
    )
    best = grasps[grasps.collision_free].sorted_by("robust_quality")[:5]
    poses: NDArray[np.float64] = best.transformed(np.eye(4)).poses
    likeness: float = egad.similarity(mesh, objects["E08_0"].mesh)
    matrix: NDArray[np.float64] = egad.similarity_matrix([mesh, mesh])
    closed: egad.Repaired = egad.repair(mesh, open_surfaces="thicken", thickness=0.002)
    chart: egad.Picture = grasps.plot()
    chart.save(folder / "quality.svg")
    shown: egad.MeshView = egad.view(closed.mesh, best, panda)
    shown.save(folder / "view.html")
    image: NDArray[np.uint8] = egad.render(mesh, size=32)
    parts: list[trimesh.Trimesh] = egad.convex_parts(mesh)
    resting: list[egad.StablePose] = egad.stable_poses(mesh)
    lying = mesh.copy().apply_transform(resting[0].matrix)
    print(voxels.sum(), factor, found.label, found.cell, poses.shape, likeness, matrix.shape)
    print(complex_ones, len(none), resting[0], best, chart)
    print(image.shape, len(parts), lying.bounds[0, 2], grasps.to_frame().columns[0])


def use_simulation(folder: Path) -> None:
    """Try detectors, evolve and export."""
    objects = egad.load("released").select("M14_3")
    mine: egad.Trials = egad.run_trials(highest_point, objects, "panda", attempts=2, seed=0)
    other = egad.run_trials("antipodal-depth", objects, "panda", attempts=2)
    best = egad.run_trials("labels", objects, "panda", attempts=2, jobs=2)
    rate: egad.Mean = mine.success_rate()
    found: egad.Comparison = best.compare(other)
    mine.plot().save(folder / "trials.svg")
    print(rate.value, rate.interval, found.difference, len(mine.table))
    archive: egad.Archive = egad.evolve(8, seed=0, measures=bulk_and_length, population=4)
    evolver = egad.Evolver(seed=0, population=4, ranges=((0.0, 3e-4), (1.0, 4.0)))
    asked: list[egad.Candidate] = evolver.ask()
    evolver.tell([bulk_and_length(candidate.mesh) for candidate in asked])
    archive.plot(measures=("bulk", "length")).save(folder / "map.svg")
    print(archive.coverage, len(evolver.archive), len(egad.load(archive)))
    print(egad.export(objects, format="acronym", gripper="panda", out=folder / "acronym", grasps=5))


def make_mistakes(folder: Path) -> None:
    """Be told what is wrong."""
    with warnings.catch_warnings(action="error", category=egad.UnitsWarning):
        try:
            egad.rescale(trimesh.creation.box((40, 50, 60)), "panda")
        except egad.UnitsWarning as warning:
            print(warning)
    (folder / "damaged.parquet").write_bytes(b"PAR1")
    errors: list[egad.EgadError] = []
    for wrong in (
        lambda: egad.Gripper(opening=0),
        lambda: egad.sample_grasps(trimesh.creation.box((0.2, 0.2, 0.2)), "panda"),
        lambda: egad.load(folder / "damaged.parquet"),
        lambda: egad.load_grasps(folder, "panda"),
    ):
        try:
            wrong()
        except (egad.UserError, egad.RejectedError, egad.TableError) as error:
            errors.append(error)
    print(*errors, sep="\n")


if __name__ == "__main__":
    here = Path.cwd()
    use_objects(here)
    use_simulation(here)
    make_mistakes(here)
