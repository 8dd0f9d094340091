"""render: depth images of the objects of a dataset at rest, with their grasps."""

import logging
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from egad._util.progress import progress
from egad.errors import RejectedError, UserError
from egad.exchange import read_mesh
from egad.exchange.hand_body import hand_body
from egad.grasps import vectors
from egad.perception import (
    GraspCandidates,
    RenderParameters,
    Share,
    encoded,
    pictures,
    shares,
)
from egad.pipeline.parameters import Input, Output, Shard, command
from egad.pipeline.stages.shards import rejection
from egad.tables import parquet
from egad.tables.columns import vector_names
from egad.tables.images import IMAGES
from egad.tables.objects import OBJECTS, REJECTED

log = logging.getLogger(__name__)

GRASP_COLUMNS = [
    "id",
    "grasp",
    *vector_names("center"),
    *vector_names("axis"),
    "width",
    "robust_quality",
]


@command()
def run(
    settings: RenderParameters,
    objects: Annotated[Path, Input()],
    meshes: Annotated[Path, Input()],
    grasps: Annotated[Path, Input()],
    shard: Shard,
    out: Annotated[Path, Output("D/images/G/images-N.parquet", IMAGES)],
    rejected: Annotated[Path, Output(schema=REJECTED)],
    evaluation: Annotated[Path | None, typer.Option("--eval"), Input()] = None,
) -> None:
    """Render the depth images of a shard, with their reachable grasps.

    A shard contains all images of the objects whose first image is in it.

    Args:
        settings: Settings of this stage.
        objects: Objects of the dataset.
        meshes: Folder of the scaled meshes.
        grasps: Labelled grasps.
        shard: Number of this shard, and number of shards.
        out: Depth images with grasps for gripper G. Made if `targets.render` is true. Read the
            folder with `egad.perception.image_shards.read`. See `docs/images.md`.
        rejected: The objects without images, with reasons.
        evaluation: Evaluation set to hold out.
    """
    number, total = shard
    chosen = [
        share
        for share in planned(settings, objects, meshes, evaluation)
        if share.images and share.first * total // settings.render.images == number
    ]
    labelled = _labelled(grasps, {share.id for share in chosen})
    body = hand_body(settings.gripper)
    rows, left_out = [], []
    for share in progress(chosen, "rendering", len(chosen)):
        try:
            mesh = read_mesh(meshes / f"{share.label}.obj", "m")
            found = pictures(mesh, labelled[share.id], share, body, settings)
            rows += [encoded(picture) for picture in found]
        except RejectedError as reason:
            left_out.append(rejection(share.id, "render", reason))
    notes = {"shard": number, "shards": total}
    parquet.write(pd.DataFrame(rows), IMAGES, out, notes)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    log.info("%d images of %d objects, %d rejected", len(rows), len(chosen), len(left_out))


def planned(
    settings: RenderParameters, objects: Path, meshes: Path, evaluation: Path | None
) -> list[Share]:
    """The images of all objects scaled to the gripper; arguments as in `run`.

    Raises:
        UserError: An evaluation set is given although none is held out, or vice versa.
    """
    if settings.render.hold_out != (evaluation is not None):
        raise UserError(
            "render.hold_out is true: the evaluation set must be given (--eval)"
            if settings.render.hold_out
            else "render.hold_out is false: no evaluation set must be given (--eval)"
        )
    table = parquet.read(objects, OBJECTS)[["id", "label", "complexity"]]
    scaled = _names(meshes / "scales.parquet", "label")
    held_out = _names(evaluation, "id") if evaluation else set()
    known = table[table["label"].isin(scaled)]
    return shares(known, held_out, settings.render, settings.seed)


def _names(path: Path, column: str) -> set[str]:
    return {name for rows in parquet.batches(path, [column]) for name in rows[column]}


def _labelled(path: Path, ids: set[str]) -> dict[str, GraspCandidates]:
    """The grasps of some objects; of one without grasps, none."""
    parts = [batch[batch["id"].isin(ids)] for batch in parquet.batches(path, GRASP_COLUMNS)]
    table = pd.concat(parts) if parts else pd.DataFrame(columns=GRASP_COLUMNS)
    groups = dict(list(table.groupby("id")))
    return {name: _grasped(groups.get(name, table.iloc[:0])) for name in ids}


def _grasped(rows: pd.DataFrame) -> GraspCandidates:
    return GraspCandidates(
        rows["grasp"].to_numpy(np.int64),
        vectors(rows, "center"),
        vectors(rows, "axis"),
        rows["width"].to_numpy(np.float64),
        rows["robust_quality"].to_numpy(np.float64),
    )
