"""Parameters of the sampling, rating and labelling of grasps."""

from typing import NamedTuple

from pydantic import Field

from egad._util.parameters import Length, ParameterGroup, Parameters, Seed, Sigma
from egad.friction import FRICTION
from egad.geometry import Material
from egad.grippers import Gripper

CONE = 0.75  # tangent of the widest angle between the axis of a grasp and its normals
APPROACH_ANGLES = 16  # around the closing axis
APPROACH_WAY = 0.1  # metres: length of the straight approach of the hand


class Quality(Parameters):
    """Ferrari-Canny grasp quality, one deterministic value per grasp."""

    friction: float = Field(FRICTION, gt=0, le=2)
    """Coulomb friction coefficient"""
    torque_scaling: float = Field(100.0, gt=0)
    """weight of a torque relative to a force, 1/m"""
    finger_radius: Length = 0.005
    """contact radius of the soft finger, metres"""


class Robust(Parameters):
    """The mean quality over perturbed copies of a grasp.

    Standard deviations per axis: object 5 mm and 0.01 rad, center of mass 10 mm, grasp 1 mm and
    0.001 rad, friction 0.1. A torque weighs 1000/m. Source: Dex-Net 2.0, Mahler et al. 2017.
    """

    samples: int = Field(25, ge=1)
    """number of perturbed copies of a grasp"""


class Spread(NamedTuple):
    """Standard deviations of the copies of a grasp of jaws, per axis: metres, radians."""

    grasp_translation_sigma: float = 0.001  # of the grasp center
    grasp_rotation_sigma: float = 0.001
    object_translation_sigma: float = 0.005
    object_rotation_sigma: float = 0.01
    com_sigma: float = 0.01
    friction_sigma: float = 0.1


SPREAD = Spread()
ROBUST_TORQUE_SCALING = 1000.0  # 1/m: weight of a torque relative to a force


class Sampling(Parameters):
    """Antipodal grasp sampler."""

    cone: float = Field(CONE, gt=0, le=2)
    """tangent of the largest angle between the grasp axis and the contact normals"""
    spacing: float = Field(0.0025, ge=0)
    """minimum distance between grasps, metres; 4.5 degrees count as 2.5 mm"""


class RobustSuction(Robust):
    """Robust quality: the share of perturbed copies that seal and resist the load.

    The paper does not give its sigmas. Those used here come from the robust quality of antipodal
    grasps (Dex-Net 2.0); that of the weight is ours.
    """

    object_translation_sigma: Sigma = SPREAD.object_translation_sigma
    """standard deviation of the object position, metres per axis"""
    object_rotation_sigma: Sigma = SPREAD.object_rotation_sigma
    """standard deviation of the object rotation, radians per axis"""
    com_sigma: Sigma = SPREAD.com_sigma
    """standard deviation of the center of mass, metres per axis"""
    friction_sigma: Sigma = SPREAD.friction_sigma
    """standard deviation of the friction coefficient"""
    cup_translation_sigma: Sigma = SPREAD.grasp_translation_sigma
    """standard deviation of the cup position, metres per axis"""
    cup_rotation_sigma: Sigma = SPREAD.grasp_rotation_sigma
    """standard deviation of the cup rotation, radians per axis"""
    weight_sigma: Sigma = 0.1
    """standard deviation of the weight of the object, relative"""


class SuctionSampling(Parameters):
    """How many suction grasps of an object, and which."""

    seed: Seed
    """seed of the candidates"""
    n: int = Field(100, ge=1)
    """number of candidates, all of which are labelled"""


class GraspLabel(Parameters):
    """How grasps of every object are sampled and tried from all sides."""

    grasps: int = Field(100, ge=1)
    """maximum number of grasps per object"""
    approach_angles: int = Field(APPROACH_ANGLES, ge=1, le=360)
    """approach angles tried, evenly spaced around the closing axis"""


class LabelParameters(ParameterGroup):
    """The settings that labelled grasps depend on."""

    seed: Seed
    gripper: Gripper
    grasp_label: GraspLabel
    sampling: Sampling
    quality: Quality
    robust: Robust
    density: float = Material().density  # of the object, kg/m3, for suction cups
