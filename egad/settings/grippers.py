"""The table of grippers."""

from pydantic import Field

from egad.settings.base import Length, Section


class Gripper(Section):
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
    friction: float = Field(0.5, gt=0, le=2, description="finger friction in simulation")


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
