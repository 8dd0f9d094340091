"""train: training of a grasp network on rendered images."""

import json
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from egad._util.extras import needed_for
from egad._util.files import write_text
from egad.errors import UserError
from egad.io import checksum
from egad.learning.dataset import ImageDataset, PositiveFilter
from egad.learning.evaluation import Score, outline_score, score_table, total_score
from egad.learning.model_card import TrainedNetwork, card
from egad.learning.parameters import TrainNetwork, TrainOnScenes
from egad.report.training import training_chart
from egad.tables import parquet
from egad.tables.training import HISTORY, SCORE

WEIGHTS = "weights.safetensors"
CHART, CARD = "history.svg", "README.md"
TABLE, REACHED = "history.parquet", "score.parquet"
CHECKPOINT = "checkpoint.pt"
FOR_PEOPLE = (WEIGHTS, CHART, CARD)


def train(
    settings: TrainNetwork,
    images: list[Path],
    out: Path,
    jobs: int = 1,
    start: Path | None = None,
    code: str = "",
) -> Score:
    """Train a network on folders of images; interrupted training resumes after its last epoch.

    The folder `out` has the network: `weights.safetensors`, its model card `README.md`,
    `history.svg`, one row per epoch of history, and the score on images of held-out objects, the
    split `test`, which is returned. See `docs/vision.md`. Weights to start from are random if
    omitted. Training resumes only with the same version of the code.

    Raises:
        UserError: PyTorch, the images of a split, or all positive grasps are missing; an object is
            in two splits; or the weights are those of another network.
        TableError: A shard cannot be read.
    """
    with needed_for("training"):
        from egad.detectors import networks, weights  # noqa: PLC0415 (an extra)
        from egad.learning import training  # noqa: PLC0415 (an extra)
    plan, seed = settings.training, settings.seed
    shards = open_dataset(images, settings)
    if start is None:
        network = networks.new_network(plan.network, seed)
    else:
        network = weights.read(start, plan.network)
    kept = training.Checkpoint(out / CHECKPOINT, fingerprint(settings, images, code, start))
    rows = training.train(network, shards, plan, seed, jobs, kept)
    held, judgements = training.evaluate_split(network, shards, plan.test, jobs)
    score = total_score(shards.index.loc[held], judgements)
    weights.write(network, out / WEIGHTS, {"network": plan.network, "seed": seed})
    trained = TrainedNetwork(
        networks.TITLES[plan.network],
        networks.parameters(network),
        folder_names(images),
        shards.index,
        pd.DataFrame(rows),
        score,
        outline_score(shards, held),
        {"seed": seed, **start_notes(start), **plan.model_dump(mode="json", exclude=plan.unused)},
    )
    parquet.write(trained.history, HISTORY, out / TABLE)
    parquet.write(score_table(trained.score), SCORE, out / REACHED)
    write_text(out / CHART, training_chart(trained.history))
    write_text(out / CARD, card(trained))
    (out / CHECKPOINT).unlink(missing_ok=True)
    return score


def open_dataset(images: Sequence[Path], settings: TrainNetwork) -> ImageDataset:
    """The training images; UserError if they do not suit the network or the settings."""
    plan = settings.training
    if plan.network == "vgn":
        raise UserError(
            "training.network is vgn, which learns from scenes; images are for ggcnn and ggcnn2"
        )
    text = "these are labelled scenes, for vgn; {network} learns from images"
    check_folders(images, "images", "scenes", text.format(network=plan.network))
    by_simulation = plan.positive == "simulated"
    shards = ImageDataset(images, PositiveFilter(plan.quality, simulated=by_simulation))
    for split in ("validation", "test"):
        shards.indices(split)
    if not shards.index.loc[shards.indices("train"), "positive"].any():
        wanted = (
            "that succeeded in simulation"
            if by_simulation
            else f"with a robust quality above training.quality, {plan.quality}"
        )
        raise UserError(
            f"{shards}: no image of the split train has a collision-free grasp {wanted}"
        )
    return shards


def check_folders(folders: Sequence[Path], wanted: str, others: str, text: str) -> None:
    """Raise `UserError` with a text if a folder holds shards of another kind, by prefixes."""
    for folder in folders:
        if any(folder.glob(f"{others}-*.parquet")) and not any(folder.glob(f"{wanted}-*.parquet")):
            raise UserError(f"{folder}: {text}")


def folder_names(folders: Sequence[Path]) -> str:
    """The folders of a training run, as its card names them; absolute ones without their place."""
    return ", ".join(path.name if path.is_absolute() else path.as_posix() for path in folders)


def start_notes(start: Path | None) -> dict[str, str]:
    """The initial weights of a training run, by name and content, if any are given."""
    return {} if start is None else {"start": f"{start.name}, sha256 {checksum(start)}"}


def fingerprint(
    settings: TrainNetwork | TrainOnScenes,
    folders: Sequence[Path],
    code: str,
    start: Path | None = None,
    device: str = "cpu",
) -> str:
    """Everything that the result of a training run depends on, as text."""
    import torch  # noqa: PLC0415 (an extra)

    files = [path for folder in folders for path in sorted(folder.glob("*-*.parquet"))]
    known = {
        "settings": settings.model_dump(
            mode="json", exclude={"training": settings.training.unused}
        ),
        "examples": [checksum(path) for path in files],
        "device": device,
        **start_notes(start),
        "torch": torch.__version__,
        "code": code,
    }
    return json.dumps(known, sort_keys=True)
