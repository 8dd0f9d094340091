"""How well released objects are placed on the map when only a copy of their mesh is known.

    python studies/measures/copies.py [FIRST] [COUNT]

prints the table of docs/measures.md for objects of a fixed random order. Needs the packages
fast_simplification and pymeshlab.
"""

import sys

import numpy as np
import pymeshlab
import trimesh

import egad
from egad.geometry.repair import repair
from egad.measures import MeasureSpace, complexity_cells, map_complexity
from egad.measures.complexity import complexity


def noisy(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """As scanned with many points, each 0.1 mm off."""
    scan = mesh.subdivide()
    scan.vertices += np.random.default_rng(0).normal(0, 1e-4, scan.vertices.shape)
    return scan


def remeshed(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """With nearly equilateral triangles of the same size."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
    edge = pymeshlab.PureValue(np.median(mesh.edges_unique_length))
    meshes.meshing_isotropic_explicit_remeshing(targetlen=edge, iterations=6)
    even = meshes.current_mesh()
    return trimesh.Trimesh(even.vertex_matrix(), even.face_matrix())


COPIES = {
    "as they are": lambda mesh: mesh,
    "each triangle in four": lambda mesh: mesh.subdivide(),
    "remeshed evenly": remeshed,
    "the same in four, 0.1 mm of noise": noisy,
    "a third of the triangles": lambda mesh: mesh.simplify_quadric_decimation(
        face_count=len(mesh.faces) // 3
    ),
}


def main(first: int = 0, count: int = 200) -> None:
    """Print a row for each kind of copy."""
    objects, space = egad.load("released"), MeasureSpace()
    labels = objects.table["label"].to_numpy()
    chosen = np.random.default_rng(61).permutation(labels)[first : first + count]
    for name, copy in COPIES.items():
        pairs = []
        for label in chosen:
            mesh = objects[str(label)].mesh
            pairs.append((complexity(mesh), map_complexity(repair(copy(mesh)).mesh)))
        own, placed = np.array(pairs).T
        apart = np.abs(complexity_cells(own, space) - complexity_cells(placed, space))
        shares = np.mean(np.abs(own - placed) <= 0.15), np.mean(apart <= 1)
        print(f"| {name} | {100 * shares[0]:.1f} % | {100 * shares[1]:.1f} % |", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
