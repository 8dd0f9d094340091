"""CPU time of a training example: `python training_time.py IMAGES`."""

import sys
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count
from pathlib import Path
from statistics import median
from time import process_time

import torch

from egad.detectors import networks
from egad.learning import ImageDataset, PositiveFilter, Training
from egad.learning.dataset import Stream
from egad.learning.evaluation import map_losses

CROPS = (96, 144, 192, 300)
TOGETHER = (1, 4)
REPEATS = 9


def main(images: Path) -> None:
    """Print the median times to prepare an example and to compute its gradient, ms, by crop."""
    torch.set_num_threads(1)
    plan = Training()
    shards = ImageDataset([images], PositiveFilter(plan.quality, plan.breadth))
    print("| crop | prepare | gradient | gradient, 4 at a time |")
    print("| --- " * 4 + "|")
    for crop in CROPS:
        stream = Stream(shards, 1000, crop=crop)
        prepared = spent(partial(prepare, stream, count()))
        gradients = [spent(partial(gradient, n, crop)) / n for n in TOGETHER]
        print(f"| {crop} | " + " | ".join(f"{time:.1f}" for time in (prepared, *gradients)) + " |")


def prepare(stream: Stream, numbers: Iterator[int]) -> object:
    """The next example of a stream."""
    return stream[next(numbers)]


def gradient(examples: int, crop: int) -> None:
    """The gradient of GG-CNN2 on some examples at once."""
    depth, wanted = torch.zeros(examples, 1, crop, crop), torch.ones(examples, 4, crop, crop)
    torch.autograd.grad(map_losses(NETWORK(depth), wanted).sum(), list(NETWORK.parameters()))


def spent(step: Callable[[], object]) -> float:
    """Median CPU time of a step, ms; the first is not counted."""
    times = []
    for _ in range(REPEATS + 1):
        before = process_time()
        step()
        times.append(1000 * (process_time() - before))
    return median(times[1:])


NETWORK = networks.new_network("ggcnn2", 0)
torch.nn.utils.convert_conv2d_weight_memory_format(NETWORK, torch.channels_last)

if __name__ == "__main__":
    main(Path(sys.argv[1]))
