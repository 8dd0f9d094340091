"""Similarity of meshes."""

from collections.abc import Sequence

import trimesh

from egad._util.arrays import Floats
from egad._util.progress import phase_if_slow
from egad.geometry.repair import repair_with_warning
from egad.measures.reeb import Similarity, extract
from egad.measures.reeb import similarity as matching


def similarity(first: trimesh.Trimesh, second: trimesh.Trimesh) -> float:
    """Similarity of two shapes by their Reeb graphs: 1 for equal ones, 0 for nothing in common.

    Args:
        first: A mesh, in any unit.
        second: Another one.

    Raises:
        RejectedError: A mesh cannot be repaired or has no Reeb graph.

    Warns:
        DroppedBodiesWarning: A mesh has several bodies; only the largest is compared.

    Source: Hilaga et al., Topology Matching, SIGGRAPH 2001.
    """
    return float(similarity_matrix([first, second])[0, 1])


@phase_if_slow("comparing meshes")
def similarity_matrix(meshes: Sequence[trimesh.Trimesh]) -> Floats:
    """Similarities of all pairs of n shapes, (n, n): symmetric, with 1 on the diagonal.

    Args:
        meshes: The shapes, each in any unit.

    Raises:
        RejectedError: A mesh cannot be repaired or has no Reeb graph.

    Warns:
        DroppedBodiesWarning: A mesh has several bodies; only the largest is compared.
    """
    parameters = Similarity()
    graphs = [extract(repair_with_warning(mesh).mesh, parameters) for mesh in meshes]
    return matching.similarity_matrix(graphs, parameters.weight)
