"""Parameters of the sampling, rating and labelling of grasps."""

from typing import Self

from pydantic import Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Seed, Sigma
from egad.geometry import Material
from egad.geometry.friction import FRICTION
from egad.grippers import Gripper

CONE = 0.75  # tangent of the widest angle between the axis of a grasp and its normals
APPROACH_ANGLES = 16  # around the closing axis


class Quality(Parameters):
    """Ferrari-Canny grasp quality, one deterministic value per grasp."""

    friction: float = Field(FRICTION, gt=0, le=2, description="Coulomb friction coefficient")
    torque_scaling: float = Field(
        100.0, gt=0, description="weight of a torque relative to a force, 1/m"
    )
    finger_radius: Length = Field(0.005, description="contact radius of the soft finger, metres")
    cone_faces: int = Field(8, ge=3, le=24, description="edges of the linearized friction cone")


class Perturbation(Parameters):
    """What the perturbed copies of any grasp share."""

    samples: int = Field(25, ge=1, description="number of perturbed copies of a grasp")
    object_translation_sigma: Sigma = Field(
        0.005, description="standard deviation of the object position, metres per axis"
    )
    object_rotation_sigma: Sigma = Field(
        0.01, description="standard deviation of the object rotation, radians per axis"
    )
    com_sigma: Sigma = Field(
        0.01, description="standard deviation of the center of mass, metres per axis"
    )
    friction_sigma: Sigma = Field(0.1, description="standard deviation of the friction coefficient")


class Robust(Perturbation):
    """The mean quality over perturbed copies of a grasp."""

    torque_scaling: float = Field(
        1000.0, gt=0, description="weight of a torque relative to a force, 1/m"
    )
    grasp_translation_sigma: Sigma = Field(
        0.001, description="standard deviation of the grasp center, metres per axis"
    )
    grasp_rotation_sigma: Sigma = Field(
        0.001, description="standard deviation of the grasp axis, radians per axis"
    )


class Sampling(Parameters):
    """Antipodal grasp sampler."""

    cone: float = Field(
        CONE,
        gt=0,
        le=2,
        description="tangent of the largest angle between the grasp axis and the contact normals",
    )
    spacing: float = Field(
        0.0025,
        ge=0,
        description="minimum distance between grasps, metres; 4.5 degrees count as 2.5 mm",
    )
    candidates: int = Field(200, ge=1, description="candidate axes sampled per round")
    rounds: int = Field(10, ge=1, description="maximum number of rounds")
    approach_clearance: float = Field(
        0.1,
        ge=0,
        description="length of the straight approach along which the open fingers must not "
        "collide, metres; 0: off (grasp labels check the whole hand instead)",
    )


class RobustSuction(Perturbation):
    """Robust quality: the share of perturbed copies that seal and resist the load.

    The paper does not give its sigmas. Those used here come from the robust quality of antipodal
    grasps (Dex-Net 2.0); that of the weight is ours.
    """

    cup_translation_sigma: Sigma = Field(
        0.001, description="standard deviation of the cup position, metres per axis"
    )
    cup_rotation_sigma: Sigma = Field(
        0.001, description="standard deviation of the cup rotation, radians per axis"
    )
    weight_sigma: Sigma = Field(
        0.1, description="standard deviation of the weight of the object, relative"
    )

    @classmethod
    def of(cls, robust: Robust) -> Self:
        """With the samples and deviations of antipodal grasps."""
        values = robust.model_dump(include=set(cls.model_fields))
        for way in ("translation_sigma", "rotation_sigma"):
            values[f"cup_{way}"] = getattr(robust, f"grasp_{way}")
        return cls(**values)


class SuctionSampling(Parameters):
    """How many suction grasps of an object, and which."""

    seed: Seed = Field(description="seed of the candidates")
    n: int = Field(100, ge=1, description="number of candidates, all of which are labelled")


class GraspLabel(Parameters):
    """How grasps of every object are sampled and tried from all sides."""

    grasps: int = Field(100, ge=1, description="maximum number of grasps per object")
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
    density: float = Material().density  # of the object, kg/m3, for suction cups
