"""Parameters of suction grasps and of their robust quality."""

from typing import Self

from pydantic import Field

from egad._util.parameters import Parameters, Seed, Sigma
from egad.grasps import Robust


class RobustSuction(Parameters):
    """Robust quality: the share of perturbed copies that seal and resist the load.

    The paper does not give its sigmas. These are those of the robust quality of antipodal grasps
    (Dex-Net 2.0); the one of the weight is ours.
    """

    samples: int = Field(25, ge=1, description="perturbed copies of a grasp")
    cup_translation_sigma: Sigma = Field(0.001, description="cup position, metres per axis")
    cup_rotation_sigma: Sigma = Field(0.001, description="cup rotation, radians per axis")
    object_translation_sigma: Sigma = Field(0.005, description="object position, metres per axis")
    object_rotation_sigma: Sigma = Field(0.01, description="object rotation, radians per axis")
    com_sigma: Sigma = Field(0.01, description="center of mass, metres per axis")
    friction_sigma: Sigma = Field(0.1, description="friction coefficient")
    weight_sigma: Sigma = Field(0.1, description="weight of the object, relative")

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
    n: int = Field(100, ge=1, description="candidates, each of them labelled")
