"""GG-CNN as the program of EGAD's robot loads it: a model of Keras in dougsm/mvp_grasp."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import torch
from torch.nn.functional import conv2d, conv_transpose2d, pad

Layer = tuple[torch.Tensor, torch.Tensor]  # kernel and bias
STRIDES = (3, 2, 2)


def keras_network(path: Path) -> Callable[[Any], Any]:
    """The network for `MapDetector`; its images are padded as by TensorFlow: less at the top."""
    layers = _layers(path)
    torch.set_num_threads(1)

    @torch.inference_mode()
    def infer(depth: Any) -> Any:  # noqa: ANN401 (arrays)
        image = torch.from_numpy(depth[None, None])
        for number, stride in enumerate(STRIDES, 1):
            image = _smaller(image, layers[f"conv2d_{number}"], stride).relu()
        for number, stride in enumerate(reversed(STRIDES), 1):
            image = _larger(image, layers[f"conv2d_transpose_{number}"], stride).relu()
        return _smaller(image, layers["maps"], 1)[0].numpy()

    return infer


def _layers(path: Path) -> dict[str, Layer]:
    with h5py.File(path) as file:
        groups = {name: group[name] for name, group in file["model_weights"].items() if len(group)}
        layers = {
            name: (
                torch.from_numpy(group["kernel:0"][()]).permute(3, 2, 0, 1),
                torch.from_numpy(group["bias:0"][()]),
            )
            for name, group in groups.items()
        }
    kernels, biases = zip(
        *(layers[f"{k}_out"] for k in ("pos", "cos", "sin", "width")), strict=True
    )
    return layers | {"maps": (torch.cat(kernels), torch.cat(biases))}


def _smaller(image: torch.Tensor, layer: Layer, stride: int) -> torch.Tensor:
    extra = layer[0].shape[-1] - stride
    return conv2d(pad(image, (extra // 2, extra - extra // 2) * 2), *layer, stride)


def _larger(image: torch.Tensor, layer: Layer, stride: int) -> torch.Tensor:
    begin, side = (layer[0].shape[-1] - stride) // 2, stride * image.shape[-1]
    whole = conv_transpose2d(image, *layer, stride)
    return whole[..., begin : begin + side, begin : begin + side]
