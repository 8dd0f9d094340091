"""How many channels of a network are idle."""

import runpy
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "experiments/training_study"


def test_idle_channels_are_counted_over_all_images():
    """Of four channels, one is 0 for all inputs and one for the negative input only."""
    torch = pytest.importorskip("torch")
    idle = runpy.run_path(str(STUDY / "initial_weights.py"))["idle"]
    layer = torch.nn.Conv2d(1, 4, 1)
    with torch.no_grad():
        layer.weight[:, 0, 0, 0] = torch.tensor([1.0, 1.0, -1.0, 0.0])
        layer.bias[:] = torch.tensor([0.0, 5.0, 0.0, -1.0])
    network = torch.nn.Sequential(layer, torch.nn.ReLU())
    inputs = torch.stack([torch.full((1, 3, 3), value) for value in (-1.0, 1.0)])
    assert idle(network, inputs) == 0.25
    assert idle(network, inputs[:1]) == 0.5
