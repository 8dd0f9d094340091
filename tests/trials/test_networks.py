"""GG-CNN itself. EGAD_GGCNN names a folder of its published weights; it needs the extra."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.errors import UserError
from egad.settings import GRIPPERS, Policy
from egad.trials.child import Child
from egad.trials.ggcnn import GGCNN

torch = pytest.importorskip("torch")
networks = pytest.importorskip("egad.trials.networks")
FOLDER = os.environ.get("EGAD_GGCNN")
HAND = GRIPPERS["egad_75mm"]
FIRST, SECOND = "ggcnn_epoch_23_cornell_statedict.pt", "epoch_50_cornell_statedict.pt"
needs_weights = [
    pytest.mark.slow,
    pytest.mark.skipif(FOLDER is None, reason="EGAD_GGCNN names no folder"),
]


def saved(path, state):
    torch.save(state, path)
    return str(path)


@pytest.mark.parametrize("name", ["_gg_cnn", "_gg_cnn2"])
def test_four_images_of_the_size_of_the_one_that_went_in(tmp_path, name):
    state = getattr(networks, name)().state_dict()
    infer = networks.load(saved(tmp_path / "weights.pt", state))
    depth = np.random.default_rng(0).normal(size=(300, 300)).astype(np.float32)
    answer = infer(depth)
    assert answer.shape == (4, 300, 300)
    np.testing.assert_array_equal(infer(depth), answer)


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ({"conv1.weight": [0.0]}, "of another network"),
        ([1, 2], "it holds a list"),
    ],
)
def test_weights_of_something_else_are_a_mistake(tmp_path, state, words):
    if isinstance(state, dict):
        state = {key: torch.tensor(value) for key, value in state.items()}
    with pytest.raises(UserError, match=f"{words}.*dougsm/ggcnn"):
        GGCNN(saved(tmp_path / "weights.pt", state))


def test_what_is_no_file_of_weights_is_a_mistake(tmp_path):
    text = tmp_path / "weights.pt"
    text.write_text("hello")
    with pytest.raises(UserError, match=r"not a state dictionary.*dougsm/ggcnn"):
        GGCNN(str(text))
    with pytest.raises(UserError, match=r"there is no file .*dougsm/ggcnn"):
        GGCNN(str(tmp_path / "missing.pt"))


def test_code_hidden_in_weights_is_not_run(tmp_path):
    class Evil:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "owned",))

    with pytest.raises(UserError, match="not a state dictionary"):
        GGCNN(saved(tmp_path / "weights.pt", {"conv1.weight": Evil()}))
    assert not (tmp_path / "owned").exists()


def published(name):
    return str(Path(FOLDER or "") / name)


def off(angle):
    """How far an axis is from another, which have no direction."""
    return abs((angle + np.pi / 2) % np.pi - np.pi / 2)


class TestPublished:
    pytestmark = needs_weights

    @pytest.mark.parametrize(("name", "most"), [(FIRST, 0.2), (SECOND, 0.5)])
    def test_a_bar_is_grasped_across(self, look, name, most):
        detect = GGCNN(published(name))
        bar = trimesh.creation.box((0.03, 0.12, 0.04))
        for turn in (0.0, 0.4, 1.0, -0.7):
            first = detect(look(bar, 0.02, -0.03, turn), HAND, np.random.default_rng(0))[0]
            assert off(first.angle - turn) < most
            along = np.array([-np.sin(turn), np.cos(turn)])
            away = np.array(first.center[:2]) - (0.02, -0.03)
            assert abs(away @ along) < 0.065
            assert abs(away @ [along[1], -along[0]]) < 0.03
            assert first.quality > 0.6

    def test_it_answers_from_a_process_of_its_own(self, look):
        view = look(trimesh.creation.box((0.03, 0.12, 0.04)))
        rng = np.random.default_rng(0)
        with Child(Policy(detector="ggcnn", weights=published(FIRST)), 60) as child:
            assert child(view, HAND, rng) == GGCNN(published(FIRST))(view, HAND, rng)
