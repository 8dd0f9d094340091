"""Parallel-jaw grippers: the ones that egad knows by name, and your own."""

from typing import Literal, NamedTuple

from pydantic import Field

from egad._util.parameters import Length, Parameters
from egad.errors import check_name


class Pad(NamedTuple):
    """What the fingers hold with, on printed plastic (typical values, ours).

    Attributes:
        friction: Sliding friction.
        radius: Of the patch where a pad touches a round object, metres; it resists twisting.
    """

    friction: float
    radius: float


PADS = {"silicone": Pad(0.8, 0.005), "bare": Pad(0.4, 0.002)}


class Gripper(Parameters):
    """A parallel-jaw gripper."""

    opening: Length = Field(description="widest opening, metres")
    finger_length: Length = Field(0.04, description="from palm to fingertip, metres")
    finger_width: Length = Field(0.02, description="of a finger across both axes, metres")
    finger_thickness: Length = Field(0.01, description="of a finger along the closing axis, metres")
    palm: tuple[Length, Length, Length] = Field(
        (0.1, 0.06, 0.05),
        description="palm box, metres: along the closing axis, across it, along the approach",
    )
    mesh: str | None = Field(
        None,
        description="file of a mesh in the place of the palm box, where collisions of grasps are "
        "looked for; metres, x closes, z is the approach, fingers begin at its origin",
    )
    force: float = Field(40.0, gt=0, description="closing force, newtons")
    pads: Literal["silicone", "bare"] = Field(
        "silicone",
        description="what the fingers hold with in simulation: silicone, friction 0.8; bare "
        "plastic or metal, 0.4",
    )
    friction: float | None = Field(
        None, gt=0, le=2, description="of the pads in simulation; else that of their material"
    )

    @property
    def pad(self) -> Pad:
        """The pads with the friction that counts."""
        pad = PADS[self.pads]
        return pad if self.friction is None else pad._replace(friction=self.friction)


_PANDA_PALM = (0.2, 0.063, 0.06)


GRIPPERS = {
    "yumi": Gripper(opening=0.05, finger_length=0.035, force=20),
    "panda": Gripper(
        opening=0.08, finger_length=0.0445, finger_width=0.021, palm=_PANDA_PALM, force=70
    ),
    "egad_75mm": Gripper(opening=0.075, finger_length=0.06, palm=_PANDA_PALM, force=70),
    "robotiq_2f_85": Gripper(
        opening=0.085,
        finger_length=0.038,
        finger_width=0.022,
        palm=(0.15, 0.075, 0.09),
        force=100,
    ),
    "robotiq_2f_140": Gripper(
        opening=0.14,
        finger_length=0.065,
        finger_width=0.027,
        palm=(0.2, 0.075, 0.09),
        force=80,
    ),
}


def gripper(name: str) -> Gripper:
    """One of the grippers that egad knows: yumi, panda, egad_75mm, robotiq_2f_85, robotiq_2f_140.

    Args:
        name: Its name.

    Raises:
        UserError: There is no gripper of this name.
    """
    return GRIPPERS[check_name("gripper", name, GRIPPERS)]


def as_gripper(hand: Gripper | str) -> Gripper:
    """A gripper, given itself or by its name.

    Raises:
        UserError: There is no gripper of this name.
    """
    return gripper(hand) if isinstance(hand, str) else hand
