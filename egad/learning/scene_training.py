"""What VGN's network learns from labelled scenes, and its answers to them.

The loss is VGN's: binary cross-entropy of the quality and, at grasps that succeeded, the distance
1 - |q.q'| of the rotation to the nearest one that holds, and 0.01 times the squared error of the
width in voxels. VGN knows one yaw of a grasp, and its half turn; here all yaws that were tried and
held are correct. VGN leaves out failed grasps until there are as many of them as of others; here
all grasps count, with weights that have the same sum for both classes.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from egad.detectors.vgn_network import VgnNetwork
from egad.errors import UserError
from egad.grippers import Gripper
from egad.learning.parameters import Training
from egad.learning.scene_examples import SceneExample, SceneStream, labelled_grasps, scene_example
from egad.learning.scene_scores import GraspAnswers, joint_average_precision, mean_loss
from egad.learning.scenes import SceneDataset
from egad.learning.training import LearningSchedule, spread, thread_pool

WIDTH_WEIGHT = 0.01
MIN_PROBABILITY = 1e-12  # a smaller probability, of an answer that is quite wrong, counts as this


class ClassWeights(NamedTuple):
    """Weights of a grasp of each class, so that both classes of a set count equally."""

    positive: float
    negative: float


def class_weights(grasps: int, positive: int) -> ClassWeights:
    """The weights of the classes of grasps, whose mean is 1; UserError if a class has no grasps."""
    if not 0 < positive < grasps:
        kind = "succeeded" if positive == 0 else "failed"
        raise UserError(f"no grasp of a scene of the split train {kind}: nothing can be learnt")
    return ClassWeights(grasps / (2 * positive), grasps / (2 * (grasps - positive)))


class SceneTask:
    """Labelled grasps of scenes; the weights of the best average precision are the result."""

    unit, score, keep_best = "scenes", "validation_average_precision", True
    parts: tuple[str, ...] = ("quality", "rotation", "width")

    def __init__(
        self,
        scenes: SceneDataset,
        gripper: Gripper,
        settings: Training,
        seed: int,
        device: str = "cpu",
    ) -> None:
        """Look for the scenes; UserError if there are none, or a class of grasps is missing."""
        rate = settings.learning_rate
        self.schedule = LearningSchedule(settings.examples, settings.epoch, settings.batch, rate)
        self._stream = SceneStream(
            scenes, gripper, settings.examples, settings.rise, seed, settings.scenes, settings.noise
        )
        counts = self._stream.index[["grasps", "positive"]]
        grasps, positive = (int(counts[name].sum()) for name in counts)
        self.weights = class_weights(grasps, positive)
        self._mean_grasps = grasps / len(counts)
        self._scenes, self._gripper, self._device = scenes, gripper, device
        self._held = spread(scenes.indices("validation"), settings.validation)

    def losses(self, network: nn.Module, number: int) -> torch.Tensor:
        """The losses of an example, (3,): sums over its grasps / their mean number in a scene."""
        example = self._stream[number]
        found = answers_at(network, example, self._device)
        return grasp_losses(found, example, self.weights).sum(dim=0) / self._mean_grasps

    def validate(self, network: nn.Module, workers: Executor) -> tuple[float, float]:
        """Loss and average precision on the validation set."""
        answers = self.evaluate(network, self._held, workers)
        return mean_loss(answers), joint_average_precision(answers)

    def evaluate(
        self, network: nn.Module, numbers: Sequence[int] | NDArray[np.int64], workers: Executor
    ) -> list[GraspAnswers]:
        """A network's answers to the scenes of some rows of the index, seen by all cameras."""
        network.eval()
        return list(workers.map(lambda number: self._answer(network, int(number)), numbers))

    def evaluate_split(
        self, network: nn.Module, split: str, most: int, jobs: int
    ) -> tuple[NDArray[np.int64], list[GraspAnswers]]:
        """At most `most` scenes of a split, by their index, and a network's answers to them."""
        held = spread(self._scenes.indices(split), most)
        with thread_pool(jobs) as workers:
            return held, self.evaluate(network, held, workers)

    def _answer(self, network: nn.Module, number: int) -> GraspAnswers:
        scene = self._scenes.scene(number)
        example = scene_example(scene.observation().tsdf, labelled_grasps(scene, self._gripper))
        with torch.inference_mode():
            found = answers_at(network, example, self._device)
            losses = grasp_losses(found, example, self.weights)
        return read_answers(found.cpu().double().numpy(), losses.cpu().double().numpy(), example)


def answers_at(network: nn.Module, example: SceneExample, device: str = "cpu") -> torch.Tensor:
    """Quality, quaternion and width at the labelled voxels of an example, (m, 6)."""
    grid = torch.from_numpy(example.grid)[None, None].to(device)
    voxels = torch.from_numpy(example.voxels).to(device)
    if isinstance(network, VgnNetwork):
        return network.at_voxels(grid, voxels)
    found: torch.Tensor = network(grid)[0][(slice(None), *voxels.T)].T
    return found


def grasp_losses(found: torch.Tensor, example: SceneExample, weights: ClassWeights) -> torch.Tensor:
    """The losses (m, 3) of quality, rotation and width, of answers (m, 6) at the grasps' voxels."""
    success, rotations, widths = (
        torch.from_numpy(values).to(found.device)
        for values in (example.success, example.rotations, example.widths)
    )
    right = torch.where(success > 0, found[:, 0], 1 - found[:, 0])
    quality = -torch.log(right.clamp(min=MIN_PROBABILITY))
    near = (found[:, None, 1:5] * rotations).sum(dim=2).abs()
    rotation = (1 - near).min(dim=1).values
    width = WIDTH_WEIGHT * (found[:, 5] - widths).square()
    weight = torch.where(success > 0, weights.positive, weights.negative)
    parts = torch.stack([quality, success * rotation, success * width], dim=1)
    return weight[:, None] * parts


def read_answers(
    found: NDArray[np.float64], losses: NDArray[np.float64], example: SceneExample
) -> GraspAnswers:
    """Answers (m, 6) at the voxels of an example, compared with its labels."""
    near = np.abs((found[:, None, 1:5] * example.rotations).sum(axis=2)).max(axis=1, initial=0)
    return GraspAnswers(
        example.success > 0,
        found[:, 0],
        np.degrees(2 * np.arccos(np.minimum(near, 1))),
        example.voxel * np.abs(found[:, 5] - example.widths),
        losses,
    )
