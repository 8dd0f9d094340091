"""The network of VGN, in PyTorch.

Breyer et al., "Volumetric grasping network", CoRL 2020. The layers have the names that they have in
the published weights.
"""

from collections.abc import Callable

import torch
from torch import nn
from torch.nn import functional

from egad._util.arrays import Singles

Infer = Callable[[Singles], Singles]

SIDE = 40  # voxels


class VgnNetwork(nn.Module):
    """From a grid of distances to quality, rotation and width of a grasp at each voxel."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.ModuleDict(_layers((1, 16, 32, 64), (5, 3, 3), 2))
        self.decoder = nn.ModuleDict(_layers((64, 64, 32, 16), (3, 3, 5), 1))
        self.conv_qual, self.conv_rot, self.conv_width = (_layer(16, n, 5, 1) for n in (1, 4, 1))

    def forward(self, grid: torch.Tensor) -> torch.Tensor:
        """Quality, quaternion (x, y, z, w) and width, (n, 6, 40, 40, 40), of (n, 1, 40, 40, 40)."""
        for layer in self.encoder.values():
            grid = torch.relu(layer(grid))
        for layer, side in zip(self.decoder.values(), (SIDE // 4, SIDE // 2, SIDE), strict=True):
            grid = functional.interpolate(torch.relu(layer(grid)), side)
        quality = torch.sigmoid(self.conv_qual(grid))
        rotation = functional.normalize(self.conv_rot(grid), dim=1)
        return torch.cat([quality, rotation, self.conv_width(grid)], dim=1)


def _layers(channels: tuple[int, ...], sizes: tuple[int, ...], stride: int) -> dict[str, nn.Conv3d]:
    pairs = zip(channels[:-1], channels[1:], sizes, strict=True)
    return {f"conv{n}": _layer(*pair, stride) for n, pair in enumerate(pairs, 1)}


def _layer(before: int, after: int, size: int, stride: int) -> nn.Conv3d:
    return nn.Conv3d(before, after, size, stride=stride, padding=size // 2)


def inference(network: VgnNetwork) -> Infer:
    """The network as a function of arrays.

    Returns:
        From a grid (40, 40, 40) to quality, quaternion and width, (6, 40, 40, 40). It runs on one
        core, so that the same grid gives the same answer.
    """
    network.eval()
    torch.set_num_threads(1)

    @torch.inference_mode()
    def infer(grid: Singles) -> Singles:
        answer: Singles = network(torch.from_numpy(grid[None, None]))[0].numpy()
        return answer

    return infer
