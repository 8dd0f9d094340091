"""Training of a grasp network on labelled scenes."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from egad._util.extras import needed_for
from egad._util.files import write_text
from egad.errors import UserError
from egad.learning.parameters import TrainOnScenes
from egad.learning.scene_model_card import TrainedOnScenes, scene_card
from egad.learning.scene_scores import (
    DECISION_THRESHOLD,
    SceneScore,
    scene_score,
    scene_score_table,
)
from egad.learning.scenes import SceneDataset, load_scenes
from egad.learning.train_on_images import (
    CARD,
    CHART,
    CHECKPOINT,
    REACHED,
    TABLE,
    WEIGHTS,
    check_folders,
    fingerprint,
    folder_names,
    start_notes,
)
from egad.report.training import scene_training_chart
from egad.tables import parquet
from egad.tables.training import SCENE_HISTORY, SCENE_SCORE


def train_on_scenes(
    settings: TrainOnScenes,
    gripper: str,
    folders: list[Path],
    out: Path,
    jobs: int = 1,
    device: str = "cpu",
    start: Path | None = None,
    code: str = "",
) -> SceneScore:
    """Train VGN's network on folders of labelled scenes; resumes after its last epoch.

    The files and the score are those of `train_on_images.train`. On `cuda`, rather than `cpu`,
    the last digits of a result may differ from run to run. The card names the gripper.

    Raises:
        UserError: PyTorch, the device, the scenes of a split, or all positive grasps are missing;
            the scenes are for another gripper, an object is in two splits, or the weights are those
            of another network.
        TableError: A shard cannot be read.
    """
    with needed_for("training"):
        from egad.detectors import networks, weights  # noqa: PLC0415
        from egad.detectors import vgn_network as vgn  # noqa: PLC0415
        from egad.learning import scene_training, training  # noqa: PLC0415
    check_device(device)
    plan, seed = settings.training, settings.seed
    if plan.network != "vgn":
        raise UserError(f"training.network is {plan.network}, which learns from images, not scenes")
    scenes = open_scenes(folders)
    if scenes.gripper != settings.gripper:
        raise UserError(
            f"{scenes.source}: these scenes are for {scenes.gripper_name}, with other settings "
            f"than those of {gripper} here"
        )
    network = (vgn.new_vgn(seed) if start is None else weights.read_vgn(start)).to(device)
    task = scene_training.SceneTask(scenes, settings.gripper, plan, seed, device)
    kept = training.Checkpoint(
        out / CHECKPOINT, fingerprint(settings, folders, code, start, device)
    )
    rows = training.learn(network, task, jobs, kept)
    _, answers = task.evaluate_split(network, "test", plan.test, jobs)
    score = scene_score(answers)
    notes = {"network": "vgn", "seed": seed, "threshold": DECISION_THRESHOLD}
    weights.write(network.cpu(), out / WEIGHTS, notes)
    trained = TrainedOnScenes(
        title=networks.TITLES["vgn"],
        parameters=networks.parameters(network),
        source=folder_names(folders),
        gripper=gripper,
        index=scenes.index,
        history=pd.DataFrame(rows),
        score=score,
        settings={
            "seed": seed,
            "device": device,
            **start_notes(start),
            **plan.model_dump(mode="json", exclude={"network", *plan.unused}),
        },
    )
    parquet.write(trained.history, SCENE_HISTORY, out / TABLE)
    parquet.write(scene_score_table(trained.score), SCENE_SCORE, out / REACHED)
    write_text(out / CHART, scene_training_chart(trained.history))
    write_text(out / CARD, scene_card(trained))
    (out / CHECKPOINT).unlink(missing_ok=True)
    return score


def check_device(device: str) -> None:
    """Raise `UserError` if PyTorch cannot compute on a device, such as a GPU that is not there."""
    import torch  # noqa: PLC0415 (an extra)

    if device == "cuda" and not torch.cuda.is_available():
        raise UserError(
            f"--device cuda: PyTorch {torch.__version__} finds no GPU; its CPU build never does"
        )


def open_scenes(folders: Sequence[Path]) -> SceneDataset:
    """The scenes to train on; `UserError` without scenes or successful grasps in a split."""
    text = "these are images, for ggcnn and ggcnn2; vgn learns from labelled scenes"
    check_folders(folders, "scenes", "images", text)
    scenes = load_scenes(list(folders))
    for split in ("train", "validation", "test"):
        if not scenes.index.loc[scenes.indices(split), "positive"].any():
            raise UserError(f"{scenes.source}: no grasp of the split {split} succeeded")
    return scenes
