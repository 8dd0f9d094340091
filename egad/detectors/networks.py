"""The networks of GG-CNN, in PyTorch.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020. The
layers have the names that they have in the published weights.
"""

import math
from collections.abc import Callable, Collection, Mapping
from typing import TypeVar

import torch
from torch import nn

from egad._util.arrays import Singles
from egad.random import entropy

TYPICAL_SPREAD = 0.01  # metres; standard deviation of the depths in images of objects on a table
SMALL = 0.1  # times the usual weights of a layer
OUTPUTS = ("pos_output", "cos_output", "sin_output", "width_output")
Infer = Callable[[Singles], Singles]
Network = TypeVar("Network", bound=nn.Module)


class Heads(nn.Module):
    """A trunk and four single layers on top of it, whose maps become one tensor."""

    def __init__(self, trunk: Mapping[str, nn.Module], channels: int, size: int) -> None:
        super().__init__()
        self._trunk = tuple(trunk)
        for name, layer in trunk.items():
            self.add_module(name, layer)
        for name in OUTPUTS:
            self.add_module(name, nn.Conv2d(channels, 1, size))

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """Quality, cos 2a, sin 2a and width (n, 4, 300, 300) of depths (n, 1, 300, 300)."""
        for name in self._trunk:
            image = self.get_submodule(name)(image)
            image = image if name == "features" else torch.relu(image)
        heads = [self.get_submodule(name) for name in OUTPUTS]
        # One convolution instead of four: GG-CNN learns from 1.6 times as many images per second.
        weight, bias = (torch.cat([getattr(head, key) for head in heads]) for key in WEIGHTS)
        return nn.functional.conv2d(image, weight, bias)


WEIGHTS = ("weight", "bias")


def gg_cnn() -> Heads:
    """The first one: down to 25 x 25 by strides and up again; 301 x 301 before the heads."""
    trunk = {
        "conv1": nn.Conv2d(1, 32, 9, stride=3, padding=3),
        "conv2": nn.Conv2d(32, 16, 5, stride=2, padding=2),
        "conv3": nn.Conv2d(16, 8, 3, stride=2, padding=1),
        "convt1": nn.ConvTranspose2d(8, 8, 3, stride=2, padding=1, output_padding=1),
        "convt2": nn.ConvTranspose2d(8, 16, 5, stride=2, padding=2, output_padding=1),
        "convt3": nn.ConvTranspose2d(16, 32, 9, stride=3, padding=3, output_padding=1),
    }
    return Heads(trunk, 32, 2)


def gg_cnn2() -> Heads:
    """The second one: pooled twice, dilated, enlarged twice; 14 and 17, bilinear, are our guess."""
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
    return Heads({"features": nn.Sequential(*layers)}, 16, 1)


MAKERS = {"ggcnn": gg_cnn, "ggcnn2": gg_cnn2}
TITLES = {"ggcnn": "GG-CNN", "ggcnn2": "GG-CNN2", "vgn": "VGN"}


def new_network(name: str, seed: int) -> Heads:
    """GG-CNN or GG-CNN2 as it is before training; its weights follow from the seed.

    Weights are by the rule of He et al. ("Delving deep into rectifiers", ICCV 2015, section 2.2),
    and biases are 0. Two changes are ours: the first layer expects an input that varies by 1 cm
    instead of 1, and the heads have a tenth of these weights, so that all answers are small. With
    Xavier's rule and the biases of PyTorch, as in GG-CNN, biases outweigh such an input, and up to
    half of the channels of a layer are 0 for every image from the beginning.
    """
    return with_initial_weights(MAKERS[name], seed, 1 / TYPICAL_SPREAD, OUTPUTS)


def with_initial_weights(
    make: Callable[[], Network], seed: int, first: float, small: Collection[str]
) -> Network:
    """A network with weights of He et al. by seed; the first layer times `first`, `small` 0.1."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(entropy(seed, "weights") % 2**63)
        network = make()
        layers = {
            name: layer
            for name, layer in network.named_modules()
            if isinstance(layer, nn.Conv2d | nn.ConvTranspose2d | nn.Conv3d)
        }
        scale = {next(iter(layers)): first, **dict.fromkeys(small, SMALL)}
        for name, layer in layers.items():
            nn.init.normal_(layer.weight, std=scale.get(name, 1) * math.sqrt(2 / _inputs(layer)))
            if layer.bias is not None:
                nn.init.zeros_(layer.bias)
    return network


def _inputs(layer: nn.Conv2d | nn.ConvTranspose2d | nn.Conv3d) -> float:
    """Number of inputs that are summed into each output."""
    values = layer.in_channels * math.prod(layer.kernel_size)
    return values / math.prod(layer.stride) if layer.transposed else values


def parameters(network: nn.Module) -> int:
    """How many numbers training can change."""
    return sum(each.numel() for each in network.parameters())


def inference(network: nn.Module) -> Infer:
    """A network as a function of arrays, on one core: the same input gives the same answer.

    GG-CNN: from depths (300, 300) of `maps.prepare_input` to quality, cos 2a, sin 2a and width,
    (4, 300, 300). VGN: from a grid (40, 40, 40) to quality, quaternion and width, (6, 40, 40, 40).
    """
    network.eval()
    torch.set_num_threads(1)

    @torch.inference_mode()
    def infer(seen: Singles) -> Singles:
        answer: Singles = network(torch.from_numpy(seen[None, None]))[0].numpy()
        return answer

    return infer
