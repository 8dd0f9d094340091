"""The network of VGN, in PyTorch.

Breyer et al., "Volumetric grasping network", CoRL 2020. The layers have the names that they have in
the published weights.
"""

import torch
from torch import nn
from torch.nn import functional

from egad.detectors.networks import with_initial_weights

HEADS = (1, 4, 1)  # channels of quality, rotation and width
REACH = 5  # voxels; side of the cube that the heads look at


class VgnNetwork(nn.Module):
    """From a grid of distances to quality, rotation and width of a grasp at each voxel."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.ModuleDict(_layers((1, 16, 32, 64), (5, 3, 3), 2))
        self.decoder = nn.ModuleDict(_layers((64, 64, 32, 16), (3, 3, 5), 1))
        self.conv_qual, self.conv_rot, self.conv_width = (_layer(16, n, REACH, 1) for n in HEADS)

    def forward(self, grid: torch.Tensor) -> torch.Tensor:
        """Quality, quaternion (x, y, z, w) and width, (n, 6, 40, 40, 40), of (n, 1, 40, 40, 40)."""
        features = functional.interpolate(self._features(grid), grid.shape[-1])
        weight, bias = self._heads()
        return _activated(functional.conv3d(features, weight, bias, padding=REACH // 2))

    def at_voxels(self, grid: torch.Tensor, voxels: torch.Tensor) -> torch.Tensor:
        """The answers at voxels (m, 3) of one grid (1, 1, n, n, n), (m, 6): heads there alone."""
        side, features = grid.shape[-1], self._features(grid)[0]
        half = features.shape[-1]
        steps = torch.arange(REACH, device=grid.device) - REACH // 2
        around = voxels[:, None] + torch.cartesian_prod(steps, steps, steps)  # (m, 125, 3)
        inside = ((around >= 0) & (around < side)).all(dim=-1)
        nearest = around.clamp(0, side - 1) * half // side  # in features before they are enlarged
        flat = (nearest[..., 0] * half + nearest[..., 1]) * half + nearest[..., 2]
        patches = (
            features.flatten(1).index_select(1, flat.flatten()).view(len(features), *flat.shape)
        )
        weight, bias = self._heads()
        patches = (patches * inside).transpose(0, 1).flatten(1)  # (m, 16 * 125)
        return _activated(functional.linear(patches, weight.flatten(1), bias))

    def _features(self, grid: torch.Tensor) -> torch.Tensor:
        """What the heads look at, at half of the resolution."""
        side = grid.shape[-1]
        for layer in self.encoder.values():
            grid = torch.relu(layer(grid))
        for layer, size in zip(self.decoder.values(), (side // 4, side // 2, None), strict=True):
            grid = torch.relu(layer(grid))
            grid = grid if size is None else functional.interpolate(grid, size)
        return grid

    def _heads(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Weight and bias of the three heads as one layer."""
        heads = (self.conv_qual, self.conv_rot, self.conv_width)
        biases = [head.bias for head in heads if head.bias is not None]
        return torch.cat([head.weight for head in heads]), torch.cat(biases)


def new_vgn(seed: int) -> VgnNetwork:
    """The network as it is before training; its weights follow from the seed.

    Weights are by the rule of He et al., and the heads of quality and width have a tenth of these,
    so that answers are small. With the initial weights of PyTorch, which VGN used, it learns
    nothing from the first few hundred scenes.
    """
    return with_initial_weights(VgnNetwork, seed, 1.0, ("conv_qual", "conv_width"))


def _activated(maps: torch.Tensor) -> torch.Tensor:
    """Quality in [0, 1], unit quaternion and width, from the sums of the heads (n, 6, ...)."""
    quality, rotation, width = torch.split(maps, list(HEADS), dim=1)
    return torch.cat([torch.sigmoid(quality), functional.normalize(rotation, dim=1), width], dim=1)


def _layers(channels: tuple[int, ...], sizes: tuple[int, ...], stride: int) -> dict[str, nn.Conv3d]:
    pairs = zip(channels[:-1], channels[1:], sizes, strict=True)
    return {f"conv{n}": _layer(*pair, stride) for n, pair in enumerate(pairs, 1)}


def _layer(before: int, after: int, size: int, stride: int) -> nn.Conv3d:
    return nn.Conv3d(before, after, size, stride=stride, padding=size // 2)
