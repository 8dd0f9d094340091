"""Training of a network: Adam on the sum of four mean squared errors.

As GG-CNN is trained (Morrison, Corke and Leitner, IJRR 2020). Ours are the learning rate, which
falls to 0, and that the same result comes out of any number of cores: each example has its gradient
computed on one core, and gradients are added up in the order of the examples. On a processor of
another kind the last digits may differ.
"""

import logging
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.errors import UserError
from egad.learning.dataset import ImageDataset, Stream
from egad.learning.evaluation import MAPS, ImageScore, map_losses, score, score_image
from egad.learning.parameters import Training

log = logging.getLogger(__name__)
Losses = NDArray[np.float64]
Row = dict[str, Any]


@dataclass
class State:
    """How far a training is.

    Attributes:
        network: As it is now.
        optimizer: With all that it remembers.
        rows: The history, one row per epoch.
    """

    network: nn.Module
    optimizer: torch.optim.Optimizer
    rows: list[Row] = field(default_factory=list)


@dataclass(frozen=True)
class Checkpoint:
    """A file for the state.

    Attributes:
        path: The file.
        fingerprint: All that decides the result; a state of another training is not taken.
    """

    path: Path
    fingerprint: str

    def save(self, state: State) -> None:
        """Write the state, atomically."""
        values = {
            "fingerprint": self.fingerprint,
            "network": state.network.state_dict(),
            "optimizer": state.optimizer.state_dict(),
            "rows": state.rows,
        }
        with atomic_output(self.path) as temporary:
            torch.save(values, temporary)

    def restore(self, state: State) -> None:
        """Bring a state to where the file is; leave it as it is if there is none that fits."""
        if not self.path.is_file():
            return
        try:
            values = torch.load(self.path, weights_only=True)
            fits = values["fingerprint"] == self.fingerprint
        except Exception as error:  # anything may be raised by a damaged file
            log.warning(
                "%s cannot be read (%s): training starts from the beginning", self.path, error
            )
            return
        if not fits:
            log.warning(
                "%s belongs to another training: this one starts from the beginning", self.path
            )
            return
        state.network.load_state_dict(values["network"])
        state.optimizer.load_state_dict(values["optimizer"])
        state.rows[:] = values["rows"]
        log.info("training resumes after epoch %d", len(state.rows))


def train(
    network: nn.Module,
    shards: ImageDataset,
    settings: Training,
    seed: int,
    jobs: int = 1,
    checkpoint: Checkpoint | None = None,
) -> list[Row]:
    """Train a network.

    Args:
        network: From depths (n, 1, side, side) to maps (n, 4, side, side), without parts that draw
            chance or look at a batch as a whole. It is changed.
        shards: The images.
        settings: How long, how fast, and on what.
        seed: Order and changes of the images follow from it.
        jobs: Cores; no result depends on it.
        checkpoint: Kept after every epoch, and gone on from.

    Returns:
        One row per epoch: columns of `tables.training.HISTORY`.

    Raises:
        UserError: There are no images to train on or to validate with, or the loss is not finite.
    """
    # Up to twice as fast as the usual order in memory.
    nn.utils.convert_conv2d_weight_memory_format(network, torch.channels_last)
    state = State(network, torch.optim.Adam(network.parameters(), lr=settings.learning_rate))
    stream = Stream(shards, settings.images, settings.zoom, settings.crop, seed)
    if checkpoint:
        checkpoint.restore(state)
    with thread_pool(jobs) as workers:
        lesson = _Lesson(state, stream, shards, settings, workers, checkpoint)
        steps = sum(len(_cut(numbers, settings.batch)) for numbers in lesson.epochs())
        words = partial(_told, state.rows)
        for _ in progress(lesson.steps(), "learning", steps, scale=settings.batch, state=words):
            pass
    return state.rows


def learning_rate(settings: Training, batch: range) -> float:
    """The learning rate of a step: it falls along half a cosine from its largest value to 0.

    Loshchilov and Hutter, "SGDR: stochastic gradient descent with warm restarts", ICLR 2017,
    equation 5, without restarts.

    Args:
        settings: How long the training is, and the largest value.
        batch: The examples of the step; the middle of them counts.
    """
    progress = (batch.start + batch.stop) / 2 / settings.images
    return settings.learning_rate * (1 + math.cos(math.pi * progress)) / 2


def evaluate(
    network: nn.Module,
    shards: ImageDataset,
    numbers: Sequence[int] | NDArray[np.int64],
    workers: Executor,
) -> list[ImageScore]:
    """A network's answers to the images of some rows of the index, compared with their grasps."""
    network.eval()
    return list(workers.map(lambda number: score_image(network, *shards.image(number)), numbers))


def evaluate_split(
    network: nn.Module, shards: ImageDataset, most: int, jobs: int
) -> tuple[NDArray[np.int64], list[ImageScore]]:
    """At most `most` images of the split `test`, by their index, and a network's scores on them."""
    held = spread(shards.indices("test"), most)
    with thread_pool(jobs) as workers:
        return held, evaluate(network, shards, held, workers)


def thread_pool(jobs: int) -> ThreadPoolExecutor:
    """Threads that compute on one core each."""
    torch.set_num_threads(1)
    return ThreadPoolExecutor(jobs, initializer=torch.set_num_threads, initargs=(1,))


def spread(numbers: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """At most `most` of the numbers, evenly spaced."""
    positions = np.linspace(0, len(numbers) - 1, min(most, len(numbers)))
    return numbers[positions.round().astype(int)]


@dataclass(frozen=True)
class _Lesson:
    """A training that is under way."""

    state: State
    stream: Stream
    shards: ImageDataset
    settings: Training
    workers: Executor
    checkpoint: Checkpoint | None

    def epochs(self) -> list[range]:
        """The examples of the epochs that are left."""
        return _cut(range(self.settings.images), self.settings.epoch)[len(self.state.rows) :]

    def steps(self) -> Iterator[None]:
        """Learn; there is a pause after each step of the optimiser."""
        held = spread(self.shards.indices("validation"), self.settings.validation)
        for numbers in self.epochs():
            losses = np.zeros(len(MAPS))
            self.state.network.train()
            for batch in _cut(numbers, self.settings.batch):
                losses += self._step(batch)
                yield
            judgements = evaluate(self.state.network, self.shards, held, self.workers)
            _note(self.state.rows, numbers.stop, losses / len(numbers), judgements)
            if self.checkpoint:
                self.checkpoint.save(self.state)

    def _step(self, batch: range) -> Losses:
        """A step along the mean gradient of some examples; returns their summed losses, (4,)."""
        results = list(self.workers.map(self._gradients, batch))
        parts = zip(*(gradients for _, gradients in results), strict=True)
        for parameter, each in zip(self.state.network.parameters(), parts, strict=True):
            parameter.grad = torch.stack(each).mean(dim=0)
        for group in self.state.optimizer.param_groups:
            group["lr"] = learning_rate(self.settings, batch)
        self.state.optimizer.step()
        total: Losses = np.sum([losses for losses, _ in results], axis=0)
        return total

    def _gradients(self, number: int) -> tuple[Losses, tuple[torch.Tensor, ...]]:
        """Losses (4,) and gradients of an example."""
        seen, wanted = (torch.from_numpy(part)[None] for part in self.stream[number])
        losses = map_losses(self.state.network(seen), wanted)
        gradients = torch.autograd.grad(losses.sum(), list(self.state.network.parameters()))
        return losses.detach().double().numpy(), gradients


def _cut(numbers: range, size: int) -> list[range]:
    """Numbers in parts of a size; the last one may be smaller."""
    ends = [*range(numbers.start, numbers.stop, size), numbers.stop]
    return [range(start, end) for start, end in pairwise(ends)]


def _note(rows: list[Row], images: int, losses: Losses, judgements: list[ImageScore]) -> None:
    """Add an epoch to the history."""
    validation = float(np.mean([each.losses.sum() for each in judgements]))
    if not math.isfinite(validation + losses.sum()):
        raise UserError("training: the loss is no longer finite; try a lower learning_rate")
    parts = {f"{name}_loss": float(loss) for name, loss in zip(MAPS, losses, strict=True)}
    rows.append(
        {
            "epoch": len(rows),
            "images": images,
            "loss": float(losses.sum()),
            **parts,
            "validation_loss": validation,
            "validation_score": score(judgements),
        }
    )


def _told(rows: list[Row]) -> str:
    if not rows:
        return ""
    last = rows[-1]
    return (
        f"epoch {last['epoch']}: validation loss {last['validation_loss']:.4f}, "
        f"score {last['validation_score']:.2f}"
    )
