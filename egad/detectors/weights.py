"""Files of weights: those that training writes, and those that were published for GG-CNN."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import safetensors
import safetensors.torch
import torch
from torch import nn

from egad._util.files import atomic_output
from egad.detectors.networks import MAKERS, TITLES, Heads
from egad.detectors.vgn_network import VgnNetwork
from egad.errors import UserError

SAFE = ".safetensors"
MAX_NAMED = 3


class WeightsError(UserError):
    """A file of weights is damaged, or of another network."""


def write(network: nn.Module, path: Path, about: Mapping[str, Any]) -> None:
    """Write the weights of a network as safetensors, atomically, with notes about it as JSON."""
    state = {name: value.contiguous() for name, value in network.state_dict().items()}
    text = json.dumps(about, sort_keys=True)  # one entry: several would come in any order
    with atomic_output(path) as temporary:
        temporary.write_bytes(safetensors.torch.save(state, {"egad": text}))


def read(path: str | Path, name: str | None = None) -> Heads:
    """Read GG-CNN or GG-CNN2, told by names, from safetensors or PyTorch; WeightsError if not."""
    state = state_in(path)
    likely = "ggcnn2" if any(key.startswith("features.") for key in state) else "ggcnn"
    network = MAKERS[name or likely]()
    which = TITLES[name] if name else "GG-CNN or GG-CNN2"
    text = f"{path}: these are not weights of {which}; most similar to {TITLES[likely]}"
    _load(network, state, text)
    return network


def read_vgn(path: str | Path) -> VgnNetwork:
    """Read VGN, as `read` reads GG-CNN; WeightsError if the file is damaged or of another kind."""
    network = VgnNetwork()
    _load(network, state_in(path), f"{path}: these are not weights of VGN")
    return network


def _load(network: nn.Module, state: Mapping[str, torch.Tensor], text: str) -> None:
    """Give a network its weights; WeightsError, beginning with `text`, if they are another's."""
    if wrong := _differences(state, network.state_dict()):
        more = f"; and {len(wrong) - MAX_NAMED} more" if len(wrong) > MAX_NAMED else ""
        raise WeightsError(f"{text}, but {'; '.join(wrong[:MAX_NAMED])}{more}")
    network.load_state_dict(state)


def notes_in(path: str | Path) -> Mapping[str, Any]:
    """The notes that `write` made in a file; empty for a file that something else has written."""
    if Path(path).suffix != SAFE:
        return {}
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            notes = json.loads((file.metadata() or {}).get("egad", "{}"))
    except Exception as error:
        raise WeightsError(f"{path} is not a complete safetensors file: {error}") from error
    return notes if isinstance(notes, dict) else {}


def state_in(path: str | Path) -> Mapping[str, torch.Tensor]:
    """The tensors of a file by their names; WeightsError if it is damaged or something else."""
    data = Path(path).read_bytes()
    if Path(path).suffix != SAFE:
        return _pickled(path)
    try:  # the header is checked against the contents
        state: dict[str, torch.Tensor] = safetensors.torch.load(data)
    except Exception as error:
        raise WeightsError(f"{path} is not a complete safetensors file: {error}") from error
    return state


def _pickled(path: str | Path) -> Mapping[str, torch.Tensor]:
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:
        raise WeightsError(f"{path} is not a state dictionary of PyTorch: {error}") from error
    if not isinstance(state, Mapping):
        raise WeightsError(f"{path} is not a state dictionary: it holds a {type(state).__name__}")
    if not all(isinstance(value, torch.Tensor) for value in state.values()):
        raise WeightsError(f"{path} is not a state dictionary: some values are not tensors")
    return state


def _differences(
    state: Mapping[str, torch.Tensor], wanted: Mapping[str, torch.Tensor]
) -> list[str]:
    """Which weights of a file differ from a network, in words."""
    words = []
    for name, value in wanted.items():
        if name not in state:
            words.append(f"{name} is missing")
        elif state[name].shape != value.shape:
            words.append(f"{name} is {_sides(state[name])}, not {_sides(value)}")
        elif state[name].dtype != value.dtype:
            words.append(f"{name} is {state[name].dtype}, not {value.dtype}")
        elif not state[name].isfinite().all():
            words.append(f"{name} has numbers that are not finite")
    return [*words, *(f"{name} is unexpected" for name in state if name not in wanted)]


def _sides(value: torch.Tensor) -> str:
    return " x ".join(map(str, value.shape)) or "a number"
