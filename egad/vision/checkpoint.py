"""The state of a training, kept after every epoch so that it can go on."""

import logging
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import nn

from egad.files import replacing

log = logging.getLogger(__name__)
Tensors = dict[str, torch.Tensor]


@dataclass
class State:
    """How far a training is.

    Attributes:
        network: As it is now.
        optimizer: With all that it remembers.
        rows: The history, a row an epoch.
        best: Weights at the lowest validation loss.
    """

    network: nn.Module
    optimizer: torch.optim.Optimizer
    rows: list[dict[str, Any]] = field(default_factory=list)
    best: Tensors = field(default_factory=dict)


@dataclass(frozen=True)
class Checkpoint:
    """A file for the state.

    Attributes:
        path: The file.
        meaning: All that decides the result; a state of another training is not taken.
    """

    path: Path
    meaning: str

    def save(self, state: State) -> None:
        """Write the state, atomically."""
        values = {
            "meaning": self.meaning,
            "network": state.network.state_dict(),
            "optimizer": state.optimizer.state_dict(),
            "rows": state.rows,
            "best": state.best,
        }
        with replacing(self.path) as temporary:
            torch.save(values, temporary)

    def restore(self, state: State) -> None:
        """Bring a state to where the file is; leave it as it is if there is none that fits."""
        if not self.path.is_file():
            return
        try:
            values = torch.load(self.path, weights_only=True)
            fits = values["meaning"] == self.meaning
        except Exception as error:  # anything may be raised by a damaged file
            log.warning("%s cannot be read (%s): training starts anew", self.path, error)
            return
        if not fits:
            log.warning("%s is of another training: this one starts anew", self.path)
            return
        state.network.load_state_dict(values["network"])
        state.optimizer.load_state_dict(values["optimizer"])
        state.rows[:], state.best = values["rows"], values["best"]
        log.info("training goes on after epoch %d", len(state.rows))
