"""Training of grasp networks on rendered images and on labelled scenes."""

from typing import Any, Literal

from pydantic import Field, model_validator

from egad._util.parameters import ParameterGroup, Parameters, with_tuples
from egad.detectors import SIZE, NoiseName
from egad.grippers import Gripper

NetworkName = Literal["ggcnn", "ggcnn2", "vgn"]
VGN_DEFAULTS = {"epoch": 1000, "batch": 4, "learning_rate": 0.0003}
FOR_IMAGES, FOR_SCENES = {"positive", "quality", "crop"}, {"scenes", "rise", "noise"}


class Training(Parameters):
    """Training of a grasp network: GG-CNN on rendered images, VGN on labelled scenes."""

    network: NetworkName = "ggcnn2"
    """GG-CNN (62,420 weights) or GG-CNN2 (66,676), trained on images; or VGN (313,238), trained on
    scenes"""
    examples: int = Field(10000, ge=1)
    """number of training examples, each a crop of an image, or a scene with its grasps"""
    scenes: int | None = Field(None, ge=1)
    """maximum number of training scenes, chosen at random; nothing: all (network: vgn)"""
    epoch: int = Field(2000, ge=1)
    """examples between two evaluations on the validation set; for vgn 1000"""
    batch: int = Field(8, ge=1)
    """examples per step of the optimizer, Adam; for vgn 4"""
    learning_rate: float = Field(0.001, gt=0, le=1)
    """initial learning rate of Adam, for vgn 0.0003; it decays to 0 along half a cosine"""
    validation: int = Field(100, ge=1)
    """maximum number of validation images or scenes to evaluate"""
    test: int = Field(1000, ge=1)
    """maximum number of test images or scenes to score the result on"""
    positive: Literal["quality", "simulated"] = "quality"
    """which collision-free grasps in images are positive: those above `quality`, or those that
    succeeded in simulation (networks: ggcnn, ggcnn2)"""
    quality: float = Field(0.001, ge=0)
    """robust quality above which grasps are positive (positive: quality)"""
    crop: int = Field(144, ge=60, le=SIZE, multiple_of=12)
    """side of the square that an example shows of an image, pixels, a multiple of 12; its position
    is sampled, as are quarter turns of the image and which fraction of its side, 0.5 to 1, is
    enlarged to the whole side (networks: ggcnn, ggcnn2)"""
    rise: int = Field(6, ge=0, le=20)
    """largest shift of a scene up or down in its cube, voxels; sampled for every example, as are
    quarter turns and the views used (network: vgn)"""
    noise: tuple[NoiseName, ...] = Field(("none",), min_length=1)
    """kinds of noise added to scenes whose images have none; one is sampled per example; validation
    and test use the images as they are (network: vgn)"""

    @model_validator(mode="before")
    @classmethod
    def _vgn_has_other_defaults(cls, given: Any) -> Any:  # noqa: ANN401 (any values of YAML)
        vgn = isinstance(given, dict) and given.get("network") == "vgn"
        return with_tuples(VGN_DEFAULTS | given if vgn else given)

    @property
    def unused(self) -> set[str]:
        """The settings of the other networks, which change nothing."""
        return FOR_IMAGES if self.network == "vgn" else FOR_SCENES


class TrainNetwork(ParameterGroup):
    """Training of a grasp network on images."""

    seed: int
    training: Training


class TrainOnScenes(ParameterGroup):
    """Training of a grasp network on labelled scenes."""

    seed: int
    training: Training
    gripper: Gripper
