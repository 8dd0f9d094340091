"""Parameters of the sampling, rating and labelling of grasps."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from pydantic import BeforeValidator, Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Seed, Sigma, UserParameters


class Pad(NamedTuple):
    """Finger pads on printed plastic (our own typical values).

    Attributes:
        friction: Sliding friction.
        radius: Radius of the contact patch on a round object, metres; it resists twisting.
    """

    friction: float
    radius: float


FRICTION = 0.5  # of the contacts that grasps are rated for
CONE = 0.75  # tangent of the widest angle between the axis of a grasp and its normals
APPROACH_ANGLES = 16  # around the closing axis
PADS = {"silicone": Pad(0.8, 0.005), "bare": Pad(0.4, 0.002)}


def _as_text(path: object) -> object:
    return str(path) if isinstance(path, Path) else path


if TYPE_CHECKING:  # what may be given; it is kept as a text
    FilePath = str | Path
else:
    FilePath = Annotated[str, BeforeValidator(_as_text)]


class Gripper(UserParameters):
    """A parallel-jaw gripper."""

    opening: Length = Field(description="widest opening, metres")
    finger_length: Length = Field(
        default=0.04, description="length of a finger from palm to fingertip, metres"
    )
    finger_width: Length = Field(
        default=0.02,
        description="width of a finger, across the closing axis and the approach, metres",
    )
    finger_thickness: Length = Field(
        default=0.01, description="thickness of a finger along the closing axis, metres"
    )
    palm: tuple[Length, Length, Length] = Field(
        default=(0.1, 0.06, 0.05),
        description="palm box, metres: along the closing axis, across it, along the approach",
    )
    mesh: FilePath | None = Field(
        default=None,
        description="mesh file, in metres, that replaces the palm box where grasps are checked for "
        "collisions; x is the closing axis, z the approach, and the origin lies midway between the "
        "fingers, where they begin",
    )
    force: float = Field(default=40.0, gt=0, description="closing force, newtons")
    pads: Literal["silicone", "bare"] = Field(
        default="silicone",
        description="finger pads in simulation: silicone, friction 0.8; or bare plastic or metal, "
        "friction 0.4",
    )
    friction: float | None = Field(
        default=None,
        gt=0,
        le=2,
        description="friction of the pads in simulation; nothing: that of their material",
    )

    @property
    def pad(self) -> Pad:
        """The pads with the friction that applies."""
        pad = PADS[self.pads]
        return pad if self.friction is None else pad._replace(friction=self.friction)


class Quality(Parameters):
    """Ferrari-Canny grasp quality, one deterministic value per grasp."""

    friction: float = Field(FRICTION, gt=0, le=2, description="Coulomb friction coefficient")
    torque_scaling: float = Field(100.0, gt=0, description="torque units per force unit, 1/m")
    finger_radius: Length = Field(0.005, description="radius of the soft finger's contact, metres")
    cone_faces: int = Field(8, ge=3, le=24, description="edges of the linearised friction cone")


class Robust(Parameters):
    """The same quality under uncertainty: the mean over perturbed copies of a grasp."""

    samples: int = Field(25, ge=1, description="perturbed copies of a grasp")
    torque_scaling: float = Field(1000.0, gt=0, description="torque units per force unit, 1/m")
    grasp_translation_sigma: Sigma = Field(0.001, description="grasp center, metres per axis")
    grasp_rotation_sigma: Sigma = Field(0.001, description="grasp axis, radians per axis")
    object_translation_sigma: Sigma = Field(0.005, description="object position, metres per axis")
    object_rotation_sigma: Sigma = Field(0.01, description="object rotation, radians per axis")
    com_sigma: Sigma = Field(0.01, description="center of mass, metres per axis")
    friction_sigma: Sigma = Field(0.1, description="friction coefficient")


class Sampling(Parameters):
    """Antipodal grasp sampler."""

    cone: float = Field(
        CONE, gt=0, le=2, description="tangent of the widest angle between axis and normals"
    )
    spacing: float = Field(
        0.0025,
        ge=0,
        description="smallest distance between grasps, metres; 4.5 degrees count as 2.5 mm",
    )
    candidates: int = Field(200, ge=1, description="candidate axes sampled per round")
    rounds: int = Field(10, ge=1, description="largest number of rounds")
    approach_clearance: float = Field(
        0.1,
        ge=0,
        description="length of the straight approach on which open fingers must not collide, "
        "metres; 0: off (grasp labels check the whole hand instead)",
    )


class GraspLabel(Parameters):
    """Labelled grasps."""

    grasps: int = Field(100, ge=1, description="largest number of grasps per object")
    approach_angles: int = Field(
        APPROACH_ANGLES,
        ge=1,
        le=360,
        description="approach angles tried, evenly spaced around the closing axis",
    )
    approach_way: float = Field(
        0.1, ge=0, le=10, description="length of the straight approach of the hand, metres"
    )


class LabelParameters(ParameterGroup):
    """The settings that labelled grasps depend on."""

    seed: Seed
    gripper: Gripper
    grasp_label: GraspLabel
    sampling: Sampling
    quality: Quality
    robust: Robust
