"""How the digits of coordinates and the size of triangles change complexity: docs/measures.md.

python docs/scripts/complexity_digits.py
"""

from collections.abc import Callable

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

import egad
from egad._util.markdown import table
from egad.geometry import to_mesh
from egad.measures import fine_complexity, is_coarse
from egad.measures.complexity import complexity

Points = NDArray[np.float64]
TURN = trimesh.transformations.euler_matrix(0.3, 0.5, 0.7)
DIGITS: dict[str, Callable[[Points], Points]] = {
    "double precision": lambda points: points,
    "single precision": lambda points: points.astype(np.float32).astype(np.float64),
    "0.000001 mm": lambda points: points.round(6),
    "six digits": np.vectorize(lambda number: float(f"{number:.6g}")),
    "0.001 mm": lambda points: points.round(3),
    "0.01 mm": lambda points: points.round(2),
}


def solids() -> dict[str, trimesh.Trimesh]:
    """Solids in millimetres."""
    box = trimesh.creation.box([60, 40, 30])
    plate = manifold3d.Manifold.cube((60, 40, 30), True)
    boss = manifold3d.Manifold.cylinder(25, 10, 10, 32).translate((0, 0, 10))
    evolved = egad.load("released")["M14_3"].mesh.copy().apply_scale(1000)
    return {
        "box": box,
        "box, 768 faces": box.subdivide().subdivide().subdivide(),
        "box with a boss": to_mesh(plate + boss),
        "cylinder, 32 sides": trimesh.creation.cylinder(20, 50, sections=32),
        "ring": trimesh.creation.annulus(20, 30, 15, sections=48),
        "M14_3": evolved,
    }


def span(values: list[float]) -> str:
    """The smallest and the largest of some numbers, or one if they are the same."""
    low, high = (f"{value + 0.0:.3f}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def with_points(mesh: trimesh.Trimesh, points: Points) -> trimesh.Trimesh:
    """The mesh with other coordinates."""
    return trimesh.Trimesh(points, mesh.faces, process=False)


def main() -> None:
    """Print the tables."""
    rows = []
    for name, mesh in solids().items():
        poses = [mesh, mesh.copy().apply_transform(TURN)]
        rounded = [
            [with_points(pose, to(pose.vertices)) for pose in poses] for to in DIGITS.values()
        ]
        rows.append([name, *(span([complexity(each) for each in pair]) for pair in rounded)])
    print(table(["complexity, bit", *DIGITS], rows))
    objects = egad.load("released")
    released = [item.mesh for item in objects]
    now = np.array([complexity(mesh) for mesh in released])
    single = np.array(
        [complexity(with_points(mesh, mesh.vertices.astype(np.float32))) for mesh in released]
    )
    coarse = is_coarse(now, [fine_complexity(mesh) for mesh in released])
    print(
        f"\nsingle precision changes the complexity of a released object by up to "
        f"{np.abs(single - now).max():.4f} bit"
    )
    print(f"{coarse.sum()} released objects are coarse")


if __name__ == "__main__":
    main()
