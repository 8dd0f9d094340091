"""The body of a gripper's hand, with the files that describe it."""

from pathlib import Path

from egad.errors import RejectedError, UserError
from egad.exchange.meshes import read_mesh
from egad.grippers import Body, BoxBody, Gripper, body_of


def hand_body(gripper: Gripper) -> Body:
    """The body of a hand: boxes, with a mesh in the place of the palm, or a maker's model.

    Raises:
        UserError: A file cannot be used.
    """
    if gripper.file is not None or gripper.mesh is None:
        return body_of(gripper)
    try:
        return BoxBody(gripper, read_mesh(Path(gripper.mesh), "m"))
    except RejectedError as reason:
        raise UserError(
            f"the mesh {gripper.mesh} of a gripper cannot be used: {reason}"
        ) from reason
