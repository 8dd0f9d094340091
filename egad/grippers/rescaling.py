"""Objects scaled to fit a gripper."""

import trimesh

from egad._util.arguments import check_positive
from egad._util.parameters import MAX_SIDE_FRACTION
from egad.geometry import SIDE_FRACTION, check_units, scaling
from egad.grippers.parameters import Gripper
from egad.grippers.table import as_gripper


def rescale(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    rule: str = "paper",
    *,
    side_fraction: float = SIDE_FRACTION,
) -> tuple[trimesh.Trimesh, float]:
    """Scale an object about the origin of its coordinates to fit a gripper.

    Coordinates in single precision, such as those of the released objects, are rounded to single
    precision again.

    Args:
        mesh: Metres; not changed.
        gripper: The gripper, or its name.
        rule: `paper`: the smallest side of the minimum-volume box becomes at most the fraction of
            the opening, smaller objects stay as they are. `egad-script`: the longest side becomes
            the opening, then as `paper`. `exact`: the smallest side becomes the fraction. `none`:
            the object stays as it is.
        side_fraction: Fraction of the opening that the rule aims at.

    Returns:
        The scaled mesh, and the factor.

    Raises:
        RejectedError: The mesh is flat.
        UserError: There is no such gripper or rule, or the fraction is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
    """
    check_units(mesh)
    fraction = check_positive("side_fraction", side_fraction, MAX_SIDE_FRACTION)
    scaled, row = scaling.rescale(mesh, rule, as_gripper(gripper).opening, fraction)
    return scaled, row["factor"]
