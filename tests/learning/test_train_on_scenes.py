"""From labelled scenes to weights, by the command; needs the extra."""

import json
import pickle
import shutil
import weakref

import numpy as np
import pandas as pd
import pytest
import trimesh
from shapes import grasps_of
from typer.testing import CliRunner

from egad.cli.commands import app
from egad.detectors import DepthCamera, DetectorConfig, Intrinsics, cameras_around, render_scene
from egad.detectors.registry import make_detector
from egad.errors import UserError
from egad.grippers import GRIPPERS
from egad.learning import Training, TrainOnScenes
from egad.learning.images import pose_values
from egad.learning.scenes import SceneDataset, write_shard
from egad.learning.scenes.making import MadeScene, view_columns
from egad.learning.train_on_images import fingerprint
from egad.learning.train_on_scenes import check_device, open_scenes, train_on_scenes
from egad.tables import parquet
from egad.tables.columns import POSE_PARTS
from egad.tables.scenes import SCENE_GRASPS
from egad.tables.training import SCENE_HISTORY, SCENE_SCORE
from egad_workflow.code_version import PACKAGES, code_version

PLAN = Training(network="vgn", examples=4, epoch=2, batch=2, validation=2, test=3)
SETTINGS = TrainOnScenes(seed=3, training=PLAN, gripper=GRIPPERS["panda"])
CAMERA = Intrinsics(160, 120, 104.0, (79.5, 59.5))
SPLITS = ("train", "train", "train", "validation", "test", "test")


def scene(number, split, noise="none", successes=None):
    """A box on the table as three cameras see it, with grasps."""
    rng = np.random.default_rng(number)
    size, turn = np.array([0.02, 0.05, 0.04]), rng.uniform(0, np.pi)
    shapes = [("box", np.array([*rng.uniform(-0.05, 0.05, 2), 0.04]), size, turn)]
    box = trimesh.creation.box(2 * size)
    matrix = trimesh.transformations.rotation_matrix(turn, [0, 0, 1])
    matrix[:3, 3] = shapes[0][1]
    cameras = cameras_around(np.array([0, 0, 0.0]), 3, 0.6, np.radians(30))
    views = [render_scene([DepthCamera(box)], [matrix], CAMERA, pose) for pose in cameras]
    table, poses = grasps_of(shapes, 12, rng)
    if successes is not None:
        table["success"] = successes
        table["width"] = table["width"].where(table["success"]).fillna(0.04)
    row = {
        "scene": number,
        "kind": "pile" if number % 2 else "packed",
        "split": split,
        "objects": [f"box{number}"],
        "factors": [1.0],
        "placements": pose_values(matrix),
        "noise": noise,
        **view_columns(views),
    }
    grasps = pd.DataFrame([pose_values(pose) for pose in poses], columns=list(POSE_PARTS))
    labels = table.assign(scene=number, object=0, id=f"box{number}", outcome="success")
    labels["yaws"] = [[each] for each in labels["success"]]
    return MadeScene(row, pd.concat([grasps, labels], axis=1)[SCENE_GRASPS.names])


@pytest.fixture(scope="module")
def made():
    noise = ("none", "dex")
    return [scene(number, split, noise[number % 2]) for number, split in enumerate(SPLITS)]


def shards_of(folder, scenes, gripper="panda"):
    about = {"set": "", "gripper": gripper, "hand": GRIPPERS[gripper].model_dump(mode="json")}
    folder.mkdir(parents=True, exist_ok=True)
    for shard in range(2):
        files = (folder / f"{name}-{shard}.parquet" for name in ("scenes", "grasps"))
        write_shard(scenes[shard::2], shard, 2, about, *files)
    return folder


@pytest.fixture(scope="module")
def scenes(made, tmp_path_factory):
    return shards_of(tmp_path_factory.mktemp("scenes"), made)


def configuration(path, **changes):
    """A file with the settings of the tests."""
    plan = PLAN.model_dump(mode="json") | changes
    path.write_text(json.dumps({"seed": 3, "training": plan}))
    return str(path)


@pytest.fixture(scope="module")
def trained(scenes, tmp_path_factory):
    """The folder of a network, made by the command in two ways."""
    pytest.importorskip("torch")
    out = tmp_path_factory.mktemp("trained")
    rest = tmp_path_factory.mktemp("config") / "rest.yaml"
    rest.write_text(json.dumps({"training": PLAN.model_dump(mode="json") | {"examples": 9}}))
    words = ["--network", "vgn", "--seed", "3", "--budget", "4", "--jobs", "2"]
    by_words = [*words, "--config", str(rest), "--out", str(out / "words")]
    whole = configuration(rest.with_name("whole.yaml"))
    by_config = ["--config", whole, "--out", str(out / "config"), "--jobs", "1"]
    for way in (by_words, by_config):
        result = CliRunner().invoke(app, ["train", str(scenes), *way])
        assert result.exit_code == 0, result.output
        assert "24 grasps in 2 scenes of held-out objects" in result.output
    return out


def test_both_ways_and_any_number_of_cores_give_the_same_bytes(trained, check_both_ways):
    check_both_ways(trained)


def test_history_and_score_are_those_of_the_card(trained, made):
    history = parquet.read(trained / "words/history.parquet", SCENE_HISTORY)
    assert history["scenes"].tolist() == [2, 4]
    (row,) = parquet.records(parquet.read(trained / "words/score.parquet", SCENE_SCORE))
    text = (trained / "words/README.md").read_text()
    successes = [int(each.grasps["success"].sum()) for each in made]
    assert (row["n_scenes"], row["n_grasps"], row["n_positive"]) == (2, 24, sum(successes[4:]))
    assert f"| average precision | {row['average_precision']:.3f} |" in text
    assert f"| mean error of the width, mm | {1000 * row['width_error']:.1f} |" in text
    assert f"The loss is {row['loss']:.4f}" in text.replace("\n", " ")
    best = history["validation_average_precision"].idxmax()
    assert f"after epoch {best}" in text
    assert f"{history['validation_loss'][best]:.4f}" in text
    header = "| split | objects | packed | piles | without a positive grasp | grasps | positive |"
    assert header in text
    assert f"| train | 3 | 2 | 1 | 0 | 36 | {sum(successes[:3])} |" in text
    assert "Cameras in each scene: 3. Noise of their images: dex in 3 scenes, none in 3" in text
    for words in (
        "313,238 weights",
        "It was trained on grasps of panda.",
        "above `threshold`, 0.5 by default",
        "| seed | 3 |",
        "| batch | 2 |",
        "| torch |",
    ):
        assert words in text
    assert "average precision, validation" not in text
    assert (trained / "words/history.svg").read_text().startswith("<?xml")


def test_the_weights_say_from_which_quality_on_grasps_are_proposed(trained):
    """Also in other processes."""
    weights = str(trained / "words/weights.safetensors")
    detect = make_detector(DetectorConfig(detector="vgn", weights=weights)).__wrapped__
    copy = pickle.loads(pickle.dumps(detect))  # noqa: S301 (as others get it)
    assert detect._threshold == copy._threshold == 0.5


def test_training_begins_with_given_weights(trained, scenes, check_start, tmp_path):
    """A few small steps hardly change them; those of another network are refused."""
    files = pytest.importorskip("egad.detectors.weights")
    start = trained / "words/weights.safetensors"
    config = configuration(tmp_path / "slow.yaml", learning_rate=0.0001)
    way = ["train", str(scenes), "--config", config, "--seed", "4"]
    check_start(way, start, "conv_qual.weight")
    networks = pytest.importorskip("egad.detectors.networks")
    files.write(networks.new_network("ggcnn", 0), tmp_path / "ggcnn.safetensors", {})
    with pytest.raises(UserError, match="not weights of VGN"):
        train_on_scenes(
            SETTINGS,
            *("panda", [scenes], tmp_path / "wrong"),
            start=tmp_path / "ggcnn.safetensors",
        )


def test_images_are_not_for_vgn_and_scenes_not_for_others(images, scenes, tmp_path):
    pytest.importorskip("torch")
    out = ["--out", str(tmp_path / "out")]
    for folder, network, text in [
        (images, "vgn", "these are images, for ggcnn and ggcnn2; vgn learns from labelled scenes"),
        (scenes, "ggcnn", "these are labelled scenes, for vgn; ggcnn learns from images"),
        (tmp_path, "vgn", "no scenes found"),
    ]:
        with pytest.raises(UserError, match=text):
            CliRunner().invoke(
                app, ["train", str(folder), "--network", network, *out], catch_exceptions=False
            )


def test_only_vgn_is_trained_on_a_gpu_and_only_if_there_is_one(images, tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    words = ["train", str(images), "--out", str(tmp_path), "--device", "cuda"]
    with pytest.raises(UserError, match="--device cuda is for the network vgn"):
        CliRunner().invoke(app, words, catch_exceptions=False)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(UserError, match=r"--device cuda: PyTorch .* finds no GPU"):
        check_device("cuda")


@pytest.mark.parametrize("split", ["train", "validation", "test"])
def test_a_split_without_a_success_is_a_mistake(made, split, tmp_path):
    failed = [
        each if each.scene["split"] != split else scene(number, split, successes=False)
        for number, each in enumerate(made)
    ]
    with pytest.raises(UserError, match=f"no grasp of the split {split} succeeded"):
        open_scenes([shards_of(tmp_path, failed)])


def test_a_training_keeps_no_scenes_in_memory(scenes, tmp_path, monkeypatch):
    pytest.importorskip("torch")
    alive, most, read = weakref.WeakSet(), [], SceneDataset.scene

    def watched(self, number):
        found = read(self, number)
        alive.add(found)
        most.append(len(alive))
        return found

    monkeypatch.setattr(SceneDataset, "scene", watched)
    train_on_scenes(SETTINGS, "panda", [scenes], tmp_path)
    assert 0 < max(most) < len(SPLITS)


def test_the_gripper_is_that_of_the_scenes(made, scenes, tmp_path):
    pytest.importorskip("torch")
    folder = shards_of(tmp_path / "scenes", made, "egad_75mm")
    config, out = configuration(tmp_path / "config.yaml"), tmp_path / "out"
    words = ["train", str(folder), "--config", config, "--out", str(out)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "It was trained on grasps of egad_75mm." in (out / "README.md").read_text()
    with pytest.raises(UserError, match="these scenes are for egad_75mm, with other settings than"):
        train_on_scenes(SETTINGS, "panda", [folder], tmp_path / "other")
    with pytest.raises(UserError, match=r"scenes for egad_75mm, but .* is for panda"):
        open_scenes([scenes, folder])


def test_what_decides_a_training_is_in_its_fingerprint(scenes, made, tmp_path):
    pytest.importorskip("torch")
    other = shards_of(tmp_path / "other", made[::-1])
    files = [tmp_path / "a.pth", tmp_path / "b.pth"]
    for path in files:
        path.write_text(path.name)
    found = [
        fingerprint(SETTINGS, [scenes], ""),
        fingerprint(SETTINGS, [scenes], "", device="cuda"),
        fingerprint(SETTINGS, [other], ""),
        fingerprint(SETTINGS.model_copy(update={"seed": 4}), [scenes], ""),
        fingerprint(SETTINGS.model_copy(update={"gripper": GRIPPERS["egad_75mm"]}), [scenes], ""),
        *(fingerprint(SETTINGS, [scenes], "", weights) for weights in files),
    ]
    assert len(set(found)) == 7
    assert fingerprint(SETTINGS, [scenes], "") == found[0]


CHANGED = [
    ("learning/scenes/reading.py", "chosen = range(self.view_count)", "chosen = range(1)", True),
    ("bench/clearing_runner.py", "POINT_SIGMA = ", "POINT_SIGMA = 2 * ", True),
    ("learning/training.py", "torch.optim.Adam(", "torch.optim.SGD(", True),
    ("learning/train_on_scenes.py", '"test", plan.test', '"validation", plan.test', True),
    # of objects to print
    ("evalset/plates.py", "SMALL_CONTACT = 1e-4", "SMALL_CONTACT = 1e-3", False),
]


@pytest.mark.parametrize(("file", "old", "new", "counts"), CHANGED)
def test_code_that_decides_a_training_is_in_its_fingerprint(tmp_path, file, old, new, counts):
    package = tmp_path / "egad"
    shutil.copytree(PACKAGES[0], package, ignore=shutil.ignore_patterns("__pycache__"))
    text = (package / file).read_text(encoding="utf-8")
    assert old in text
    (package / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    module = "egad.learning.train_on_scenes"
    assert (code_version(module, (package,)) != code_version(module)) == counts
