"""The mesh file of a gripper's palm."""

from pathlib import Path

import trimesh

from egad.errors import RejectedError, UserError
from egad.exchange.meshes import read_mesh
from egad.grasps import Gripper, parts


def palm_mesh(gripper: Gripper) -> trimesh.Trimesh | None:
    """The mesh in the place of a gripper's palm box, if it has one.

    Raises:
        UserError: The file cannot be used.
    """
    if gripper.mesh is None:
        return None
    try:
        mesh = read_mesh(Path(gripper.mesh), "m")
        parts(gripper, mesh)
    except RejectedError as reason:
        raise UserError(
            f"the mesh {gripper.mesh} of a gripper cannot be used: {reason}"
        ) from reason
    return mesh
