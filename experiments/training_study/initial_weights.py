"""Idle channels before training: `python initial_weights.py IMAGES`.

For GG-CNN2 with its published initial weights (Xavier's rule, the biases of PyTorch) and with those
of egad, by seed: the largest fraction of channels of a layer that are 0 everywhere in all images.
IMAGES is a folder of images such as `results/training_study/images/evolved`. Also prints the median
of the standard deviations of the depths in these images.
"""

import sys
from pathlib import Path

import numpy as np
import torch
from torch import nn

from egad._util.markdown import table
from egad.detectors import fill_missing, networks, prepare_input
from egad.learning import ImageDataset, PositiveFilter, Training

IMAGES = 100
SEEDS = 5


def main(images: Path) -> None:
    """Print the table."""
    plan = Training()
    dataset = ImageDataset([images], PositiveFilter(plan.quality, plan.breadth))
    numbers = dataset.indices("train")[:IMAGES]
    depths = np.stack([dataset.image(number)[0] for number in numbers])
    spreads = [1000 * float(np.nanstd(depth)) for depth in depths]
    print(f"standard deviation of the depths in an image: {np.median(spreads):.0f} mm")
    inputs = torch.from_numpy(
        np.stack([prepare_input(fill_missing(depth)) for depth in depths])[:, None]
    )
    rows = [
        (seed, *(f"{idle(make(seed), inputs):.0%}" for make in (as_published, as_here)))
        for seed in range(SEEDS)
    ]
    print(table(["seed", "published initial weights", "egad's"], rows))


def as_here(seed: int) -> nn.Module:
    """GG-CNN2 as egad trains it."""
    return networks.new_network("ggcnn2", seed)


def as_published(seed: int) -> nn.Module:
    """GG-CNN2 with Xavier's rule and the biases of PyTorch."""
    torch.manual_seed(seed)
    network = networks.gg_cnn2()
    for layer in network.modules():
        if isinstance(layer, nn.Conv2d):
            nn.init.xavier_uniform_(layer.weight)
    return network


@torch.inference_mode()
def idle(network: nn.Module, inputs: torch.Tensor) -> float:
    """The largest fraction of a layer's channels that are 0 everywhere in all images."""
    found: dict[nn.Module, torch.Tensor] = {}

    def note(layer: nn.Module, _: object, answer: torch.Tensor) -> None:
        highest = answer.amax(dim=(0, 2, 3))
        found[layer] = torch.maximum(found.get(layer, highest), highest)

    for layer in network.modules():
        if isinstance(layer, nn.ReLU):
            layer.register_forward_hook(note)
    for image in inputs:
        network(image[None])
    return max(float((highest == 0).float().mean()) for highest in found.values())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
