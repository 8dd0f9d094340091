"""Training; needs the extra."""

import math

import numpy as np
import pandas as pd
import pytest

from egad.errors import UserError
from egad.learning import Training
from egad.learning import evaluation as scoring
from egad.learning.dataset import ImageDataset, PositiveFilter, example
from egad.tables.training import HISTORY

torch = pytest.importorskip("torch")
networks = pytest.importorskip("egad.detectors.networks")
training = pytest.importorskip("egad.learning.training")
interrupted = pytest.importorskip("interrupted")
SHORT = Training(network="ggcnn", examples=10, epoch=4, batch=3, validation=2, crop=96)


@pytest.fixture(scope="module")
def shards(images):
    return ImageDataset([images], PositiveFilter(0.002, 0.02))


class Tiny(torch.nn.Conv2d):
    """Hardly a network."""

    def __init__(self, scale=1.0):
        super().__init__(1, 4, 1)
        torch.nn.init.constant_(self.weight, 0.1 * scale)
        torch.nn.init.constant_(self.bias, 0.1)


def trained(shards, settings=SHORT, seed=0, jobs=1, kept=None):
    network = networks.new_network("ggcnn", seed)
    rows = training.train(network, shards, settings, seed, jobs, kept)
    return rows, network.state_dict()


@pytest.fixture(scope="module")
def undisturbed(shards):
    return trained(shards)


def test_nothing_but_the_seed_decides(shards, undisturbed):
    assert interrupted.same(trained(shards, jobs=2), undisturbed)
    assert not interrupted.same(trained(shards, seed=1), undisturbed)


def test_it_goes_on_after_an_interruption_with_the_same_result(shards, undisturbed, tmp_path):
    path = tmp_path / "checkpoint.pt"
    with pytest.raises(interrupted.InterruptionError):
        trained(shards, kept=interrupted.Breaking(path, "this"))
    assert interrupted.same(trained(shards, kept=training.Checkpoint(path, "this")), undisturbed)


@pytest.mark.parametrize("damage", [False, True])
def test_a_checkpoint_of_something_else_is_not_taken(shards, undisturbed, tmp_path, caplog, damage):
    path = tmp_path / "checkpoint.pt"
    with pytest.raises(interrupted.InterruptionError):
        training.train(Tiny(), shards, SHORT, 0, 1, interrupted.Breaking(path, "that"))
    if damage:
        path.write_bytes(path.read_bytes()[:300])
    assert interrupted.same(trained(shards, kept=training.Checkpoint(path, "this")), undisturbed)
    assert ("cannot be read" if damage else "belongs to another training") in caplog.text


def test_the_history_tells_every_epoch(undisturbed):
    history = pd.DataFrame(undisturbed[0])
    assert list(history) == HISTORY.names
    assert history["images"].tolist() == [4, 8, 10]
    parts = history[["quality_loss", "cosine_loss", "sine_loss", "width_loss"]].sum(axis=1)
    np.testing.assert_allclose(parts, history["loss"])


def test_the_last_weights_are_those_of_the_history(shards):
    network = Tiny()
    rows = training.train(network, shards, SHORT, 0)
    held = training.spread(shards.indices("validation"), SHORT.validation)
    with training.thread_pool(1) as workers:
        judgements = training.evaluate(network, shards, held, workers)
    loss = np.mean([each.losses.sum() for each in judgements])
    assert loss == pytest.approx(rows[-1]["validation_loss"])


def test_the_learning_rate_falls_along_half_a_cosine():
    """Values of a cosine that are known: the full rate, 3/4, half and 1/4 of it, and nothing."""
    schedule = training.LearningSchedule(examples=600, epoch=4, batch=3, learning_rate=0.04)
    middles = [0, 200, 300, 400, 600]
    rates = [training.learning_rate(schedule, range(n - 1, n + 1)) for n in middles]
    np.testing.assert_allclose(rates, [0.04, 0.03, 0.02, 0.01, 0], atol=1e-12)


def test_a_loss_that_is_not_finite_ends_it(shards):
    with pytest.raises(UserError, match="no longer finite; try a lower learning_rate"):
        training.train(Tiny(math.inf), shards, SHORT, 0)


def test_a_step_is_one_along_the_gradient_of_the_whole_batch(shards):
    """Gradients computed image by image are those of a batch, as everybody else computes them."""
    settings = SHORT.model_copy(update={"examples": 3, "epoch": 3})
    network, other = Tiny(), Tiny()
    training.train(network, shards, settings, 0)
    stream = training.Stream(shards, 3, settings.crop, 0)
    seen, wanted = (
        torch.from_numpy(np.stack(part))
        for part in zip(*(stream[n] for n in range(3)), strict=True)
    )
    rate = training.learning_rate(training.ImageTask(shards, settings, 0).schedule, range(3))
    optimizer = torch.optim.Adam(other.parameters(), lr=rate)
    answer = other(seen)
    loss = sum(torch.nn.functional.mse_loss(answer[:, k], wanted[:, k]) for k in range(4))
    loss.backward()
    optimizer.step()
    torch.testing.assert_close(network.weight, other.weight)


def test_numbers_are_spread_evenly():
    assert training.spread(np.arange(10), 3).tolist() == [0, 4, 9]
    assert training.spread(np.arange(3), 10).tolist() == [0, 1, 2]


class TestScoring:
    def test_a_network_that_knows_the_answer_is_always_right(self, shards):
        for number in shards.indices("train")[:6]:
            depth, truth = shards.image(number)
            maps = torch.from_numpy(example(depth, truth)[1])[None]
            judged = scoring.score_image(lambda _, maps=maps: maps, depth, truth)
            assert judged.losses.tolist() == [0, 0, 0, 0]
            assert judged.hit is (True if len(truth) else None)

    def test_a_wrong_answer_is_wrong_by_its_squares(self, shards):
        depth, truth = shards.image(1)
        judged = scoring.score_image(lambda _: torch.full((1, 4, 300, 300), 2.0), depth, truth[:0])
        np.testing.assert_allclose(judged.losses, 4)
        assert scoring.score_image(lambda _: torch.zeros(1, 4, 300, 300), depth, truth).hit is False

    def test_images_without_a_good_grasp_do_not_count(self):
        hits = [True, None, False, True, None]
        assert scoring.score([scoring.ImageScore(np.zeros(4), hit) for hit in hits]) == 2 / 3
        assert math.isnan(scoring.score([]))
