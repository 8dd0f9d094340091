"""From images to weights, by the command; needs the extra."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from egad.cli.commands import app
from egad.detectors import prepare_input
from egad.detectors.ggcnn import GGCNN, middle
from egad.errors import TableError, UserError
from egad.learning import Training, TrainNetwork
from egad.learning.train_on_images import fingerprint, open_dataset, train
from egad.tables import parquet
from egad.tables.training import HISTORY, SCORE

PLAN = Training(
    examples=4, epoch=2, batch=2, validation=2, test=3, quality=0.002, network="ggcnn", crop=96
)
SETTINGS = TrainNetwork(seed=3, training=PLAN)


def configuration(path, seed=SETTINGS.seed, **changes):
    """A file with the settings of the tests, and these changes of the training."""
    path.write_text(json.dumps({"seed": seed, "training": PLAN.model_dump(mode="json") | changes}))
    return str(path)


@pytest.fixture(scope="module")
def trained(images, tmp_path_factory):
    """The folder of a network, made by the command in two ways."""
    pytest.importorskip("torch")
    out = tmp_path_factory.mktemp("trained")
    rest = configuration(out / "rest.yaml", seed=8, examples=9, network="ggcnn2")
    words = ["--network", "ggcnn", "--seed", "3", "--budget", "4", "--jobs", "2"]
    by_words = [*words, "--config", rest, "--out", str(out / "words")]
    whole = configuration(out / "whole.yaml")
    by_config = ["--config", whole, "--out", str(out / "config"), "--jobs", "1"]
    for way in (by_words, by_config):
        result = CliRunner().invoke(app, ["train", str(images), *way])
        assert result.exit_code == 0, result.output
        assert "images of held-out objects" in result.output
    return out


def test_both_ways_and_any_number_of_cores_give_the_same_bytes(trained, check_both_ways):
    check_both_ways(trained)


def test_the_history_is_there_and_says_where_it_is_from(trained):
    path = trained / "words/history.parquet"
    assert parquet.read(path, HISTORY)["images"].tolist() == [2, 4]
    assert parquet.origin_of(path)["stage"] == "train"
    assert parquet.origin_of(path)["seed"] == 3


def test_the_score_is_that_of_the_card(trained):
    (row,) = parquet.records(parquet.read(trained / "words/score.parquet", SCORE))
    text = (trained / "words/README.md").read_text()
    said = "correct in {n_correct} of {n_images} images of {objects} held-out objects".format(**row)
    assert said in text.replace("\n", " ")
    assert f"The loss is {row['loss']:.4f}" in text.replace("\n", " ")


def test_the_card_says_what_it_learnt_from_and_how(trained, pictures):
    text = (trained / "words/README.md").read_text()
    splits = [row["split"] for row in pictures]
    for split in ("train", "validation", "test"):
        count = splits.count(split)
        assert f"| {split} | {count // 3} | {count} | {count // 3} |" in text
    for words in ("62,420 weights", "| seed | 3 |", "| batch | 2 |", "| torch |", "history.svg"):
        assert words in text
    assert "4 examples in 2 epochs" in text


def test_the_detector_takes_the_weights(trained, view):
    safetensors = pytest.importorskip("safetensors.torch")
    networks = pytest.importorskip("egad.detectors.networks")
    path, seen = trained / "words/weights.safetensors", prepare_input(middle(view.depth).depth)
    network = networks.new_network("ggcnn", 0)
    before = networks.inference(network)(seen)
    network.load_state_dict(safetensors.load_file(path))
    after = networks.inference(network)(seen)
    assert not np.array_equal(before, after)
    np.testing.assert_array_equal(GGCNN(str(path))._infer(seen), after)


def test_training_begins_with_given_weights(trained, images, check_start, tmp_path):
    """A few small steps hardly change them; those of the other network are refused."""
    start = trained / "words/weights.safetensors"
    config = configuration(tmp_path / "slow.yaml", seed=4, learning_rate=0.0001)
    way = ["train", str(images), "--config", config]
    check_start(way, start, "conv2.weight")
    other = SETTINGS.model_copy(update={"training": PLAN.model_copy(update={"network": "ggcnn2"})})
    with pytest.raises(UserError, match="not weights of GG-CNN2; most similar to GG-CNN, but"):
        train(other, [images], tmp_path / "wrong", start=start)


def test_another_network_has_other_defaults():
    vgn = Training(network="vgn", batch=2)
    assert (vgn.epoch, vgn.batch, vgn.learning_rate) == (1000, 2, 0.0003)


def test_a_checkpoint_does_not_depend_on_settings_of_other_networks():
    pytest.importorskip("torch")

    def of(**changes):
        plan = PLAN.model_copy(update=changes)
        return fingerprint(SETTINGS.model_copy(update={"training": plan}), [], "code")

    assert of(rise=3, noise=("dex",), scenes=7) == of()
    assert of(crop=120) != of()
    assert of(network="vgn", crop=120) == of(network="vgn") != of(network="vgn", rise=3)


def test_nothing_to_learn_from_is_a_mistake(write, pictures, tmp_path):
    strict = SETTINGS.model_copy(update={"training": PLAN.model_copy(update={"quality": 1.0})})
    with pytest.raises(
        UserError, match=r"no image of the split train has a collision-free grasp .*quality, 1\.0"
    ):
        open_dataset([write(tmp_path / "all", pictures)], strict)
    kept = [row for row in pictures if row["split"] != "test"]
    with pytest.raises(UserError, match="no image in the split test"):
        open_dataset([write(tmp_path / "some", kept)], SETTINGS)


def test_simulated_labels_are_asked_for_if_they_decide(write, pictures, tmp_path):
    plan = PLAN.model_copy(update={"positive": "simulated"})
    settings = SETTINGS.model_copy(update={"training": plan})
    with pytest.raises(TableError, match="columns are missing: simulated_success"):
        open_dataset([write(tmp_path / "none", pictures)], settings)
    rows = [
        {**row, "simulated_success": [None if free else True for free in row["collision_free"]]}
        for row in pictures
    ]
    folder = write(tmp_path / "colliding", rows)
    with pytest.raises(UserError, match="collision-free grasp that succeeded in simulation"):
        open_dataset([folder], settings)


@pytest.mark.usefixtures("without_torch")
def test_without_pytorch_the_message_names_the_extra(tmp_path):
    with pytest.raises(UserError, match=r"egad\[vision\]"):
        train(SETTINGS, [tmp_path], tmp_path)
