"""Training on scenes of known geometry; needs the extra."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import ShapeScenes

from egad.errors import UserError
from egad.grippers import GRIPPERS
from egad.learning import Training
from egad.learning.scene_examples import SceneExample
from egad.learning.scene_scores import scene_score
from egad.tables.training import SCENE_HISTORY

torch = pytest.importorskip("torch")
training = pytest.importorskip("egad.learning.training")
lessons = pytest.importorskip("egad.learning.scene_training")
vgn = pytest.importorskip("egad.detectors.vgn_network")
interrupted = pytest.importorskip("interrupted")

HAND = GRIPPERS["panda"]
SHORT = Training(examples=10, epoch=4, batch=3, validation=2, rise=1)
LONG = Training(examples=400, epoch=100, batch=2, learning_rate=0.001, rise=1)


@pytest.fixture(scope="module")
def scenes():
    return ShapeScenes(10, 20)


def trained(scenes, settings=SHORT, seed=0, jobs=1, kept=None):
    network = vgn.new_vgn(seed)
    task = lessons.SceneTask(scenes, HAND, settings, seed)
    return training.learn(network, task, jobs, kept), network.state_dict()


@pytest.fixture(scope="module")
def undisturbed(scenes):
    return trained(scenes)


class TestNetwork:
    @pytest.mark.parametrize("side", [20, 40])
    def test_answers_at_voxels_are_those_of_the_whole_grid(self, side):
        network, rng = vgn.new_vgn(0), np.random.default_rng(0)
        grid = torch.from_numpy(rng.random((1, 1, side, side, side)).astype(np.float32))
        ends = [[0, 0, 0], [side - 1] * 3, [0, side - 1, 1]]
        voxels = torch.tensor([*ends, *rng.integers(0, side, (20, 3)).tolist()])
        both = network(grid)[0][:, *voxels.T].T, network.at_voxels(grid, voxels)
        torch.testing.assert_close(both[1], both[0], atol=1e-5, rtol=1e-4)
        weights = list(network.parameters())
        gradients = [torch.autograd.grad(each.square().sum(), weights) for each in both]
        for one, other in zip(*gradients, strict=True):
            torch.testing.assert_close(one, other, atol=1e-3, rtol=1e-3)


def example_of(success, rotations, widths, turns=(0, 180)):
    """Labels at as many voxels of an empty grid, right at some turns, degrees."""
    about = [Rotation.from_euler("z", turn, degrees=True) for turn in turns]
    quaternions = np.array([[(each * turn).as_quat() for turn in about] for each in rotations])
    return SceneExample(
        np.zeros((20, 20, 20), np.float32),
        np.zeros((len(success), 3), np.int64),
        np.array(success, np.float32),
        quaternions.astype(np.float32),
        np.array(widths, np.float32),
        0.015,
    )


class TestLoss:
    def test_it_is_that_of_vgn_grasp_by_grasp(self):
        """By a loop over the grasps, in double precision."""
        rng = np.random.default_rng(0)
        example = example_of([1, 0, 1, 0], list(Rotation.random(4, rng)), [3, 0, 4, 0])
        answers = np.column_stack(
            [rng.uniform(0.1, 0.9, 4), Rotation.random(4, rng).as_quat(), rng.uniform(0, 9, 4)]
        )
        weights = lessons.ClassWeights(2.0, 0.75)
        found = lessons.grasp_losses(torch.from_numpy(answers).float(), example, weights)
        for k in range(4):
            quality, rotation, width = answers[k, 0], answers[k, 1:5], answers[k, 5]
            if example.success[k]:
                near = min(1 - abs(rotation @ other) for other in example.rotations[k])
                wide = 0.01 * (width - example.widths[k]) ** 2
                wanted = 2 * np.array([-math.log(quality), near, wide])
            else:
                wanted = 0.75 * np.array([-math.log(1 - quality), 0, 0])
            np.testing.assert_allclose(found[k], wanted, rtol=1e-5)

    def test_the_nearest_of_all_turns_that_hold_counts(self):
        """Three turns hold; the answer is 10 degrees beyond the last."""
        turn = Rotation.from_euler("xyz", [2.5, 0.3, 0.4])
        example = example_of([1], [turn], [2], turns=(0, 36, 108, 180, 216, 288))
        answer = (turn * Rotation.from_euler("z", 118, degrees=True)).as_quat()
        answers = np.array([[1 - 1e-6, *answer, 2]])
        weights = lessons.ClassWeights(1, 1)
        losses = lessons.grasp_losses(torch.from_numpy(answers).float(), example, weights)
        assert losses[0, 1] == pytest.approx(1 - math.cos(math.radians(5)), abs=1e-5)
        read = lessons.read_answers(answers, losses.double().numpy(), example)
        assert read.angles == pytest.approx(10, abs=0.05)

    def test_both_classes_count_alike(self):
        weights = lessons.class_weights(100, 20)
        assert 20 * weights.positive == 80 * weights.negative == 50
        for positive in (0, 100):
            with pytest.raises(UserError, match="nothing can be learnt"):
                lessons.class_weights(100, positive)


class TestTraining:
    def test_nothing_but_the_seed_decides(self, scenes, undisturbed):
        assert interrupted.same(trained(scenes, jobs=2), undisturbed)
        assert not interrupted.same(trained(scenes, seed=1), undisturbed)

    def test_it_goes_on_after_an_interruption_with_the_same_result(
        self, scenes, undisturbed, tmp_path
    ):
        path = tmp_path / "checkpoint.pt"
        with pytest.raises(interrupted.InterruptionError):
            trained(scenes, kept=interrupted.Breaking(path, "this"))
        assert interrupted.same(
            trained(scenes, kept=training.Checkpoint(path, "this")), undisturbed
        )

    def test_the_history_tells_every_epoch(self, undisturbed):
        rows = undisturbed[0]
        assert [list(row) for row in rows] == [SCENE_HISTORY.names] * 3
        assert [row["scenes"] for row in rows] == [4, 8, 10]
        for row in rows:
            parts = row["quality_loss"] + row["rotation_loss"] + row["width_loss"]
            assert parts == pytest.approx(row["loss"])

    @pytest.mark.parametrize("best", [0, 1, 2])
    def test_the_weights_of_the_best_epoch_are_the_result(self, scenes, best, tmp_path):
        """Also if the training was interrupted after it."""
        seen = []

        class Told(lessons.SceneTask):
            def validate(self, network, _workers):
                seen.append({key: each.clone() for key, each in network.state_dict().items()})
                return 1.0, 0.9 if len(seen) - 1 == best else 0.5

        def learn(kept):
            network = vgn.new_vgn(0)
            training.learn(network, Told(scenes, HAND, SHORT, 0), 1, kept)
            return network.state_dict()

        path = tmp_path / "checkpoint.pt"
        with pytest.raises(interrupted.InterruptionError):
            learn(interrupted.Breaking(path, ""))
        result = learn(training.Checkpoint(path, ""))
        assert len(seen) == 3
        assert [all(torch.equal(result[key], each[key]) for key in each) for each in seen] == [
            number == best for number in range(3)
        ]

    def test_the_score_is_of_the_weights_that_are_kept(self, scenes):
        network = vgn.new_vgn(0)
        task = lessons.SceneTask(scenes, HAND, SHORT, 0)
        rows = training.learn(network, task)
        _, answers = task.evaluate_split(network, "validation", 2, 1)
        best = max(row["validation_average_precision"] for row in rows)
        assert scene_score(answers).average_precision.value == best


class TestLearning:
    """Grasps of few scenes are learnt for others, and nothing from shuffled labels."""

    def score(self, shuffled):
        scenes = ShapeScenes(60, 40, shuffled=shuffled)
        network = vgn.new_vgn(0)
        task = lessons.SceneTask(scenes, HAND, LONG, 0)
        training.learn(network, task)
        return scene_score(task.evaluate_split(network, "test", 100, 1)[1])

    def test_geometry_is_learnt(self):
        score = self.score(shuffled=False)
        assert score.average_precision.interval[0] > score.share + 0.1
        assert score.balanced_accuracy.value > 0.75
        assert score.width.value < 0.01
