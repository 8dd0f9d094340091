"""Training of a network: Adam, with a learning rate that falls to 0.

The result does not depend on the number of cores: the gradient of each example is computed on one
core, and gradients are added up in the order of the examples. On a processor of another kind the
last digits may differ. `ImageTask` is what GG-CNN learns (Morrison, Corke and Leitner, IJRR 2020).
"""

import logging
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, Protocol

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
Weights = dict[str, torch.Tensor]


class LearningSchedule(NamedTuple):
    """Examples in all, per epoch (one validation) and per step; the largest learning rate."""

    examples: int
    epoch: int
    batch: int
    learning_rate: float


class Task(Protocol):
    """What a network learns.

    `unit` is what examples are called in the history, `parts` names the losses that are summed,
    `score` the score, better if higher. If `keep_best`, the weights after the epoch of the best
    score are the result; else the last ones are.
    """

    schedule: LearningSchedule
    unit: str
    parts: tuple[str, ...]
    score: str
    keep_best: bool

    def losses(self, network: nn.Module, number: int) -> torch.Tensor:
        """The losses of an example, one for each part."""

    def validate(self, network: nn.Module, workers: Executor) -> tuple[float, float]:
        """Loss and score on the validation set."""


@dataclass
class State:
    """How far a training is; `best` has the weights of the best epoch, if these are wanted."""

    network: nn.Module
    optimizer: torch.optim.Optimizer
    rows: list[Row] = field(default_factory=list)
    best: Weights = field(default_factory=dict)


@dataclass(frozen=True)
class Checkpoint:
    """A file for the state; one of another fingerprint, of all that matters, is not used."""

    path: Path
    fingerprint: str

    def save(self, state: State) -> None:
        """Write the state, atomically."""
        values = {
            "fingerprint": self.fingerprint,
            "network": state.network.state_dict(),
            "optimizer": state.optimizer.state_dict(),
            "rows": state.rows,
            "best": state.best,
        }
        with atomic_output(self.path) as temporary:
            torch.save(values, temporary)

    def restore(self, state: State) -> None:
        """Restore a state from the file; leave it as it is if there is no file that fits."""
        if not self.path.is_file():
            return
        try:
            values = torch.load(self.path, map_location="cpu", weights_only=True)
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
        state.best = values["best"]
        log.info("training resumes after epoch %d", len(state.rows))


def train(
    network: nn.Module,
    shards: ImageDataset,
    settings: Training,
    seed: int,
    jobs: int = 1,
    checkpoint: Checkpoint | None = None,
) -> list[Row]:
    """Train a network on images, see `learn`; it maps (n, 1, side, side) to (n, 4, side, side).

    It must not be random or look at a batch as a whole. Rows of the history are
    `tables.training.HISTORY`. UserError also if there are no images to train on or to validate
    with.
    """
    # Up to twice as fast as the usual order in memory.
    nn.utils.convert_conv2d_weight_memory_format(network, torch.channels_last)
    return learn(network, ImageTask(shards, settings, seed), jobs, checkpoint)


def learn(
    network: nn.Module, task: Task, jobs: int = 1, checkpoint: Checkpoint | None = None
) -> list[Row]:
    """Train a network, which is modified; `jobs` does not change the result.

    The checkpoint is saved after every epoch, and training resumes from it. Returns one row per
    epoch: `epoch`; examples so far, by the unit of the task; `loss` and its parts;
    `validation_loss` and the score. UserError if the loss is not finite.
    """
    state = State(network, torch.optim.Adam(network.parameters(), lr=task.schedule.learning_rate))
    if checkpoint:
        checkpoint.restore(state)
    with thread_pool(jobs) as workers:
        lesson = _Lesson(state, task, workers, checkpoint)
        size = task.schedule.batch
        steps = sum(len(_cut(numbers, size)) for numbers in lesson.epochs())
        words = partial(_told, state.rows, task.score)
        for _ in progress(lesson.steps(), "learning", steps, scale=size, state=words):
            pass
    if state.best:
        network.load_state_dict(state.best)
    return state.rows


def learning_rate(schedule: LearningSchedule, batch: range) -> float:
    """Half a cosine down to 0, at the middle of a step (Loshchilov and Hutter, SGDR)."""
    progress = (batch.start + batch.stop) / 2 / schedule.examples
    return schedule.learning_rate * (1 + math.cos(math.pi * progress)) / 2


class ImageTask:
    """Four maps of images, by the sum of their mean squared errors."""

    unit, score, keep_best = "images", "validation_score", False
    parts: tuple[str, ...] = MAPS

    def __init__(self, shards: ImageDataset, settings: Training, seed: int) -> None:
        """Look for the images; UserError if there are none to train on or to validate with."""
        rate = settings.learning_rate
        self.schedule = LearningSchedule(settings.examples, settings.epoch, settings.batch, rate)
        self._stream = Stream(shards, settings.examples, settings.crop, seed)
        self._shards = shards
        self._held = spread(shards.indices("validation"), settings.validation)

    def losses(self, network: nn.Module, number: int) -> torch.Tensor:
        """The losses of an example, (4,)."""
        seen, wanted = (torch.from_numpy(part)[None] for part in self._stream[number])
        return map_losses(network(seen), wanted)

    def validate(self, network: nn.Module, workers: Executor) -> tuple[float, float]:
        """Loss and score on the validation set."""
        judgements = evaluate(network, self._shards, self._held, workers)
        return float(np.mean([each.losses.sum() for each in judgements])), score(judgements)


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
    """A training in progress."""

    state: State
    task: Task
    workers: Executor
    checkpoint: Checkpoint | None

    def epochs(self) -> list[range]:
        """The examples of the epochs that are left."""
        schedule = self.task.schedule
        return _cut(range(schedule.examples), schedule.epoch)[len(self.state.rows) :]

    def steps(self) -> Iterator[None]:
        """Train, with a pause after each step of the optimizer."""
        for numbers in self.epochs():
            losses = np.zeros(len(self.task.parts))
            self.state.network.train()
            for batch in _cut(numbers, self.task.schedule.batch):
                losses += self._step(batch)
                yield
            self._note(numbers.stop, losses / len(numbers))
            if self.checkpoint:
                self.checkpoint.save(self.state)

    def _step(self, batch: range) -> Losses:
        """A step along the mean gradient of some examples; returns their summed losses."""
        results = list(self.workers.map(self._gradients, batch))
        parts = zip(*(gradients for _, gradients in results), strict=True)
        for parameter, each in zip(self.state.network.parameters(), parts, strict=True):
            parameter.grad = torch.stack(each).mean(dim=0)
        for group in self.state.optimizer.param_groups:
            group["lr"] = learning_rate(self.task.schedule, batch)
        self.state.optimizer.step()
        total: Losses = np.sum([losses for losses, _ in results], axis=0)
        return total

    def _gradients(self, number: int) -> tuple[Losses, tuple[torch.Tensor, ...]]:
        losses = self.task.losses(self.state.network, number)
        gradients = torch.autograd.grad(losses.sum(), list(self.state.network.parameters()))
        return losses.detach().cpu().double().numpy(), gradients

    def _note(self, examples: int, losses: Losses) -> None:
        """Validate after an epoch and add it to the history."""
        state, task = self.state, self.task
        loss, value = task.validate(state.network, self.workers)
        if not math.isfinite(loss + losses.sum()):
            raise UserError("training: the loss is no longer finite; try a lower learning_rate")
        parts = zip(task.parts, losses, strict=True)
        if task.keep_best and value > max((row[task.score] for row in state.rows), default=-1):
            weights = state.network.state_dict()
            state.best = {name: each.detach().clone() for name, each in weights.items()}
        state.rows.append(
            {
                "epoch": len(state.rows),
                task.unit: examples,
                "loss": float(losses.sum()),
                **{f"{name}_loss": float(each) for name, each in parts},
                "validation_loss": loss,
                task.score: value,
            }
        )


def _cut(numbers: range, size: int) -> list[range]:
    """Numbers in parts of a size; the last one may be smaller."""
    ends = [*range(numbers.start, numbers.stop, size), numbers.stop]
    return [range(start, end) for start, end in pairwise(ends)]


def _told(rows: list[Row], score: str) -> str:
    if not rows:
        return ""
    last, words = rows[-1], score.removeprefix("validation_").replace("_", " ")
    return (
        f"epoch {last['epoch']}: validation loss {last['validation_loss']:.4f}, "
        f"{words} {last[score]:.2f}"
    )
