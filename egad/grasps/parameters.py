"""Parameters of the sampling, rating and labelling of grasps."""

from pydantic import Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Sigma
from egad.grasps.gripper import Gripper


class Quality(Parameters):
    """Ferrari-Canny grasp quality, one deterministic value a grasp."""

    friction: float = Field(0.5, gt=0, le=2, description="Coulomb friction coefficient")
    torque_scaling: float = Field(100.0, gt=0, description="torque units a force unit, 1/m")
    finger_radius: Length = Field(0.005, description="radius of the soft finger's contact, metres")
    cone_faces: int = Field(8, ge=3, le=24, description="edges of a linearised friction cone")


class Robust(Parameters):
    """The same quality under uncertainty: the mean over disturbed copies of a grasp."""

    samples: int = Field(25, ge=1, description="disturbed copies of a grasp")
    torque_scaling: float = Field(1000.0, gt=0, description="torque units a force unit, 1/m")
    grasp_translation_sigma: Sigma = Field(0.001, description="grasp center, metres an axis")
    grasp_rotation_sigma: Sigma = Field(0.001, description="grasp axis, radians an axis")
    object_translation_sigma: Sigma = Field(0.005, description="object position, metres an axis")
    object_rotation_sigma: Sigma = Field(0.01, description="object rotation, radians an axis")
    com_sigma: Sigma = Field(0.01, description="center of mass, metres an axis")
    friction_sigma: Sigma = Field(0.1, description="friction coefficient")


class Sampling(Parameters):
    """Antipodal grasp sampler."""

    cone: float = Field(
        0.75, gt=0, le=2, description="tangent of the widest angle between axis and normals"
    )
    spacing: float = Field(
        0.0025, ge=0, description="least distance of two grasps, metres; 4.5 degrees count 2.5 mm"
    )
    candidates: int = Field(200, ge=1, description="candidate axes drawn in one round")
    rounds: int = Field(10, ge=1, description="most rounds until enough grasps are found")
    approach_clearance: float = Field(
        0.1,
        ge=0,
        description="open fingers must reach their place from this far, metres; 0: off "
        "(grasp labels test the whole hand instead)",
    )


class GraspLabel(Parameters):
    """Labelled grasps."""

    grasps: int = Field(100, ge=1, description="most grasps an object")
    approach_angles: int = Field(
        16, ge=1, le=360, description="approaches tried, spread evenly around the closing axis"
    )
    approach_way: float = Field(
        0.1, ge=0, le=10, description="the hand comes in straight from this far, metres"
    )


class LabelParameters(ParameterGroup):
    """What labelled grasps depend on."""

    seed: int
    gripper: Gripper
    grasp_label: GraspLabel
    sampling: Sampling
    quality: Quality
    robust: Robust
