"""Training of grasp networks on rendered images."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Length, Parameters, PositiveFraction


class Training(Parameters):
    """Training of a grasp network on rendered images."""

    network: Literal["ggcnn", "ggcnn2"] = Field(
        "ggcnn2", description="GG-CNN, 62,420 weights, or GG-CNN2, 66,676"
    )
    images: int = Field(
        16000,
        ge=1,
        description="most images to learn from, each again with every pass; 15 minutes on two "
        "cores at most",
    )
    epoch: int = Field(1000, ge=1, description="images between two looks at the validation set")
    batch: int = Field(8, ge=1, description="images a step of the optimiser, Adam")
    learning_rate: float = Field(0.001, gt=0, le=1, description="of Adam")
    patience: int | None = Field(
        5,
        ge=1,
        description="training ends after this many epochs without a lower validation loss, and the "
        "weights of the lowest are taken; nothing: it goes to its end, and the last are taken",
    )
    validation: int = Field(
        250, ge=1, description="most images of the validation set that are looked at"
    )
    test: int = Field(
        1000, ge=1, description="most images of the test set that the result is scored on"
    )
    quality: float = Field(
        0.001, ge=0, description="robust quality that a grasp to learn must have more of"
    )
    breadth: Length = Field(0.02, description="of the jaws, in the grasps to learn, metres")
    zoom: tuple[PositiveFraction, PositiveFraction] = Field(
        (0.5, 1.0),
        description="part of an image's side that is shown, from and to; it is drawn anew every "
        "time, as are quarter turns",
    )

    @model_validator(mode="after")
    def _zoom_goes_from_low_to_high(self) -> Self:
        if self.zoom[0] > self.zoom[1]:
            raise ValueError(f"zoom must go from low to high, got {self.zoom}")
        return self
