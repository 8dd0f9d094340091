"""Solids at the edges of the map: `python studies/search/attainable_cells.py`.

It prints the tables of README.md, "Which cells can be reached": the best grasp, balls,
cubes with hairs, and simple solids as they are and as evolution makes them, of 25 x 25 x 25 voxels.
"""

import warnings
from collections.abc import Callable, Mapping

import numpy as np
import trimesh
from numpy.typing import NDArray

import egad
from egad.evolution import Shape
from egad.evolution.growth import surface
from egad.grasps import ferrari_canny
from egad.measures import attainable_graspability, default_measures

Solid = NDArray[np.bool_]
VOXELS = 25
SETTINGS = default_measures(egad.gripper("yumi"), 0)


def best_grasp() -> float:
    """Quality of a grasp through the center of mass, with both normals along the axis."""
    points = [[[0, 0, -0.02], [0, 0, 0.02]]]
    return float(ferrari_canny(points, [[[0, 0, -1], [0, 0, 1]]], [[0, 0, 1]], [0, 0, 0])[0])


def hairy_cube(side: float) -> trimesh.Trimesh:
    """A cube with hairs along its axes, which make its box 40 mm wide; sides in metres."""
    bars = [np.where(np.eye(3)[k], 0.04, 1e-5) for k in range(3)]
    solids = [trimesh.creation.box([side] * 3), *map(trimesh.creation.box, bars)]
    return trimesh.boolean.union(solids, engine="manifold")


def disc(thickness: float) -> trimesh.Trimesh:
    """A disc of diameter 1."""
    return trimesh.creation.cylinder(0.5, thickness, sections=128)


def voxel_disc(thickness: int) -> Solid:
    """A disc of voxels, as wide as the grid; its thickness is in voxels."""
    x, y, z = _grid()
    return (x**2 + y**2 <= (VOXELS / 2) ** 2) & (abs(z) < thickness / 2)


def voxel_plate(thickness: int) -> Solid:
    """A square plate of voxels."""
    return abs(_grid()[2]) < thickness / 2


def voxel_rod(thickness: int) -> Solid:
    """A round rod of voxels."""
    x, y, _ = _grid()
    return x**2 + y**2 <= (thickness / 2) ** 2


def _grid() -> NDArray[np.float64]:
    """Centers of the voxels, (3, 25, 25, 25), relative to the center of the grid."""
    middle = (VOXELS - 1) / 2
    return np.indices((VOXELS,) * 3) - middle


PAIRS: Mapping[str, tuple[Callable[[float], trimesh.Trimesh], Callable[[int], Solid]]] = {
    "disc": (disc, voxel_disc),
    "square plate": (lambda part: trimesh.creation.box([1, 1, part]), voxel_plate),
    "rod": (lambda part: trimesh.creation.cylinder(part / 2, 1, sections=128), voxel_rod),
}


def _row(name: str, mesh: trimesh.Trimesh) -> None:
    found = egad.measure(mesh)
    std = 1000 * found.graspability_std
    print(
        f"| {name} | {found.complexity:.2f} | {1000 * found.graspability:.3f} ± {std:.3f} | "
        f"{found.label} |",
        flush=True,
    )


def main() -> None:
    """Print the tables."""
    limit = attainable_graspability(SETTINGS)
    print(
        f"best grasp {1000 * best_grasp():.4f}, bound {1000 * limit.quality:.4f}, "
        f"expected percentile at most {1000 * limit.graspability:.3f}: {limit.row_names}"
    )
    print("| solid | complexity | graspability, 1e-3 | cell |\n| --- | --- | --- | --- |")
    for rounds in (2, 3, 4, 5):
        ball = trimesh.creation.icosphere(rounds)
        _row(f"ball of {len(ball.faces)} triangles", ball)
    for side in (0.02, 0.01, 0.005, 0.003, 0.002):
        _row(f"cube of {1000 * side:g} mm with hairs", hairy_cube(side))
    for name, (exact, voxels) in PAIRS.items():
        for thickness in (3, 5, 8, 11):
            _row(f"{name}, 1 : {VOXELS / thickness:.2g}", exact(thickness / VOXELS))
            _row("the same of voxels", surface(voxels(thickness), Shape()))


if __name__ == "__main__":
    warnings.simplefilter("ignore", egad.ScaleWarning)
    main()
