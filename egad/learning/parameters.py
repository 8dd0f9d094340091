"""Training of grasp networks on rendered images and on labelled scenes."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Length, ParameterGroup, Parameters, PositiveFraction
from egad.detectors import SIZE, NoiseName
from egad.grippers import Gripper

NetworkName = Literal["ggcnn", "ggcnn2", "vgn"]
LearningRate = Annotated[
    float,
    Field(
        gt=0, le=1, description="initial learning rate of Adam; it decays to 0 along half a cosine"
    ),
]


class Training(Parameters):
    """Training of a grasp network on rendered images."""

    network: NetworkName = Field(
        "ggcnn2",
        description="GG-CNN (62,420 weights) or GG-CNN2 (66,676); or VGN (313,238), which is "
        "trained on labelled scenes with the settings of `training_vgn` instead of those here",
    )
    images: int = Field(
        10000, ge=1, description="number of training examples, each a crop of an image"
    )
    epoch: int = Field(
        2000, ge=1, description="examples between two evaluations on the validation set"
    )
    batch: int = Field(8, ge=1, description="examples per step of the optimizer, Adam")
    learning_rate: LearningRate = 0.001
    validation: int = Field(
        100, ge=1, description="maximum number of validation images to evaluate"
    )
    test: int = Field(
        1000, ge=1, description="maximum number of test images to score the result on"
    )
    positive: Literal["quality", "simulated"] = Field(
        "quality",
        description="which collision-free grasps are positive: those above `quality`, or those "
        "that succeeded in simulation",
    )
    quality: float = Field(
        0.001,
        ge=0,
        description="robust quality above which grasps are positive (positive: quality)",
    )
    breadth: Length = Field(0.02, description="width of the jaws in the training labels, metres")
    zoom: tuple[PositiveFraction, PositiveFraction] = Field(
        (0.5, 1.0),
        description="range of the fraction of an image's side that is enlarged to the whole side; "
        "sampled for every example, as are quarter turns",
    )
    crop: int = Field(
        144,
        ge=60,
        le=SIZE,
        multiple_of=12,
        description="side of the square of an enlarged image that an example shows, pixels, a "
        "multiple of 12; its position is also sampled",
    )

    @model_validator(mode="after")
    def _zoom_goes_from_low_to_high(self) -> Self:
        if self.zoom[0] > self.zoom[1]:
            raise ValueError(f"zoom must go from low to high, got {self.zoom}")
        return self


class VgnTraining(Parameters):
    """Training of the network of VGN on labelled scenes; see `training.network`."""

    examples: int = Field(
        10000, ge=1, description="number of training examples, each a scene with its grasps"
    )
    scenes: int | None = Field(
        None, ge=1, description="maximum number of training scenes, chosen at random; nothing: all"
    )
    epoch: int = Field(
        1000, ge=1, description="examples between two evaluations on the validation set"
    )
    batch: int = Field(4, ge=1, description="examples per step of the optimizer, Adam")
    learning_rate: LearningRate = 0.0003
    validation: int = Field(
        100, ge=1, description="maximum number of validation scenes to evaluate"
    )
    test: int = Field(
        1000, ge=1, description="maximum number of test scenes to score the result on"
    )
    rise: int = Field(
        6,
        ge=0,
        le=20,
        description="largest shift of a scene up or down in its cube, voxels; sampled for every "
        "example, as are quarter turns and the views used",
    )
    noise: tuple[NoiseName, ...] = Field(
        ("none",),
        min_length=1,
        description="kinds of noise added to scenes whose images have none; one is sampled per "
        "example; validation and test use the images as they are",
    )


class TrainNetwork(ParameterGroup):
    """Training of a grasp network on images."""

    seed: int
    training: Training


class TrainOnScenes(ParameterGroup):
    """Training of a grasp network on labelled scenes."""

    seed: int
    training_vgn: VgnTraining
    gripper: Gripper
