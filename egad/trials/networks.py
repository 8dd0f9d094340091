"""The networks of GG-CNN, in PyTorch, with weights that were trained elsewhere.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020. The
layers have the names that they have in the published weights.
"""

from collections.abc import Callable, Mapping

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

OUTPUTS = ("pos_output", "cos_output", "sin_output", "width_output")
Image = NDArray[np.float32]
Network = Callable[[Image], Image]


def load(path: str) -> Network:
    """Read the weights of GG-CNN or GG-CNN2; which of them is seen from their names.

    Args:
        path: File of a state dictionary.

    Returns:
        From a depth image of 300 x 300, metres less their mean, to quality, cos 2a, sin 2a and
        width, (4, 300, 300). It runs on one core, so that the same image gives the same answer.

    Raises:
        ValueError: The file holds something else.
    """
    state = _state(path)
    network = _gg_cnn2() if "features.0.weight" in state else _gg_cnn()
    try:
        network.load_state_dict(state)
    except RuntimeError as error:
        raise ValueError(
            f"{path}: the weights are of another network than GG-CNN and GG-CNN2"
        ) from error
    network.eval()
    torch.set_num_threads(1)

    @torch.inference_mode()
    def infer(depth: Image) -> Image:
        answer: Image = network(torch.from_numpy(depth[None, None]))[0].numpy()
        return answer

    return infer


def _state(path: str) -> Mapping[str, torch.Tensor]:
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:
        raise ValueError(f"{path} is not a state dictionary of PyTorch: {error}") from error
    if not isinstance(state, Mapping):
        raise ValueError(f"{path} is not a state dictionary: it holds a {type(state).__name__}")
    return state


class _Heads(nn.Module):
    """A trunk and four single layers on top of it, whose images become one tensor."""

    def __init__(self, trunk: Mapping[str, nn.Module], channels: int, size: int) -> None:
        super().__init__()
        self._trunk = tuple(trunk)
        for name, layer in trunk.items():
            self.add_module(name, layer)
        for name in OUTPUTS:
            self.add_module(name, nn.Conv2d(channels, 1, size))

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        for name in self._trunk:
            image = self.get_submodule(name)(image)
            image = image if name == "features" else torch.relu(image)
        return torch.cat([self.get_submodule(name)(image) for name in OUTPUTS], dim=1)


def _gg_cnn() -> nn.Module:
    """The first one: down to 25 x 25 by strides and up again; 301 x 301 before the heads."""
    trunk = {
        "conv1": nn.Conv2d(1, 32, 9, stride=3, padding=3),
        "conv2": nn.Conv2d(32, 16, 5, stride=2, padding=2),
        "conv3": nn.Conv2d(16, 8, 3, stride=2, padding=1),
        "convt1": nn.ConvTranspose2d(8, 8, 3, stride=2, padding=1, output_padding=1),
        "convt2": nn.ConvTranspose2d(8, 16, 5, stride=2, padding=2, output_padding=1),
        "convt3": nn.ConvTranspose2d(16, 32, 9, stride=3, padding=3, output_padding=1),
    }
    return _Heads(trunk, 32, 2)


def _gg_cnn2() -> nn.Module:
    """The second one: pooled twice, dilated in the middle, enlarged twice.

    The weights have no place for the transposed convolutions that the project's code has now:
    14 and 17 are layers without weights. That these are bilinear is ours to guess.
    """
    layers = [
        *(nn.Conv2d(1, 16, 11, padding=5), nn.ReLU()),
        *(nn.Conv2d(16, 16, 5, padding=2), nn.ReLU(), nn.MaxPool2d(2)),
        *(nn.Conv2d(16, 16, 5, padding=2), nn.ReLU()),
        *(nn.Conv2d(16, 16, 5, padding=2), nn.ReLU(), nn.MaxPool2d(2)),
        *(nn.Conv2d(16, 32, 5, padding=4, dilation=2), nn.ReLU()),
        *(nn.Conv2d(32, 32, 5, padding=8, dilation=4), nn.ReLU(), nn.UpsamplingBilinear2d(None, 2)),
        *(nn.Conv2d(32, 16, 3, padding=1), nn.ReLU(), nn.UpsamplingBilinear2d(None, 2)),
        *(nn.Conv2d(16, 16, 3, padding=1), nn.ReLU()),
    ]
    return _Heads({"features": nn.Sequential(*layers)}, 16, 1)
