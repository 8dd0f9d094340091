"""Training of grasp networks on rendered images."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Length, Parameters, PositiveFraction


class Training(Parameters):
    """Training of a grasp network on rendered images."""

    network: Literal["ggcnn", "ggcnn2"] = Field(
        "ggcnn2", description="GG-CNN (62,420 weights) or GG-CNN2 (66,676)"
    )
    images: int = Field(
        16000,
        ge=1,
        description="largest number of training images, counted again in every pass; the default "
        "takes at most 15 minutes on two cores",
    )
    epoch: int = Field(
        1000, ge=1, description="images between two evaluations on the validation set"
    )
    batch: int = Field(8, ge=1, description="images per step of the optimiser, Adam")
    learning_rate: float = Field(0.001, gt=0, le=1, description="learning rate of Adam")
    patience: int | None = Field(
        5,
        ge=1,
        description="training stops after this many epochs without a lower validation loss, and "
        "keeps the weights with the lowest; nothing: it does not stop early and keeps the last",
    )
    validation: int = Field(
        250, ge=1, description="largest number of validation images that are evaluated"
    )
    test: int = Field(
        1000, ge=1, description="largest number of test images that the result is scored on"
    )
    quality: float = Field(0.001, ge=0, description="grasps are positive above this robust quality")
    breadth: Length = Field(0.02, description="width of the jaws in the training labels, metres")
    zoom: tuple[PositiveFraction, PositiveFraction] = Field(
        (0.5, 1.0),
        description="range of the fraction of an image's side that is shown; it is sampled anew "
        "for every use of an image, as are quarter turns",
    )

    @model_validator(mode="after")
    def _zoom_goes_from_low_to_high(self) -> Self:
        if self.zoom[0] > self.zoom[1]:
            raise ValueError(f"zoom must go from low to high, got {self.zoom}")
        return self
