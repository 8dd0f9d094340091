"""Parameters of suction grasps and of their robust quality."""

from typing import Self

from pydantic import Field

from egad._util.parameters import Parameters, Seed, Sigma
from egad.grasps import Perturbation, Robust


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
