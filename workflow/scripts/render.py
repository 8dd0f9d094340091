"""render: depth images of the objects of a dataset at rest, with their grasps."""

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster, mass_properties
from egad.grasps import ContactPairs
from egad.grippers import HandBody, hand_body
from egad.io import read_mesh
from egad.learning.images import (
    PlacedObject,
    RenderedImage,
    RenderImages,
    RenderParameters,
    Share,
    draw_width,
    encoded,
    first_good,
    model_at_size,
    pictures,
    place,
    sample_factor,
    settle_scene,
    shares,
    simulate_contacts,
    views_of,
)
from egad.sim import read_parts
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.images import IMAGES
from egad.tables.objects import OBJECTS, REJECTED, rejection
from egad_workflow.job import run_job

log = logging.getLogger(__name__)
KEPT = 200  # objects kept in memory


@dataclass(frozen=True)
class KnownObject:
    """An object of the dataset, at the size that fits the gripper; parts may be missing."""

    id: str
    mesh: trimesh.Trimesh
    parts: tuple[trimesh.Trimesh, ...]

    @cached_property
    def com(self) -> Floats:
        """Its center of mass, (3,), metres."""
        return mass_properties(self.mesh, 1.0).com

    @cached_property
    def caster(self) -> RayCaster:
        """Ray caster of its mesh."""
        return RayCaster(self.mesh)


def run(
    settings: RenderImages,
    objects: Path,
    meshes: Path,
    shard: tuple[int, int],
    out: Path,
    rejected: Path,
    evaluation: Path | None = None,
    convex_parts: Path | None = None,
) -> None:
    """Render the depth images of a shard, with their reachable grasps."""
    number, total = shard
    chosen = [
        share
        for share in planned(settings, objects, meshes, evaluation)
        if share.images and share.first * total // settings.render.images == number
    ]
    studio = Studio(settings, parquet.read(objects, OBJECTS), meshes, convex_parts)
    rows, left_out = [], []
    for share in progress(chosen, "rendering", len(chosen)):
        try:
            found = [encoded(picture) for picture in studio.pictures(share)]
            if not found:
                raise RejectedError("no pose and size with a good grasp was found")
            rows += found
        except RejectedError as reason:
            left_out.append(rejection(share.id, "render", reason))
    notes = {"shard": number, "shards": total}
    parquet.write(pd.DataFrame(rows), IMAGES, out, notes)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    log.info("%d images of %d objects, %d rejected", len(rows), len(chosen), len(left_out))


def planned(
    settings: RenderParameters, objects: Path, meshes: Path, evaluation: Path | None
) -> list[Share]:
    """The images of all objects scaled to the gripper; an evaluation set must be held out."""
    if settings.render.hold_out != (evaluation is not None):
        raise UserError(
            "render.hold_out is true: the evaluation set must be given"
            if settings.render.hold_out
            else "render.hold_out is false: no evaluation set must be given"
        )
    table = parquet.read(objects, OBJECTS)[["id", "label", "complexity"]]
    scaled = parquet.distinct(meshes / "scales.parquet", "label")
    held_out = parquet.distinct(evaluation, "id") if evaluation else set()
    known = table[table["label"].isin(scaled)]
    return shares(known, held_out, settings.render, settings.seed)


class Studio:
    """Makes the images of the objects of a dataset."""

    def __init__(
        self, settings: RenderImages, objects: pd.DataFrame, meshes: Path, convex_parts: Path | None
    ) -> None:
        """Take the inputs of the images; convex parts if they are needed, or `UserError`."""
        if settings.render.needs_convex_parts and convex_parts is None:
            raise UserError(
                "render.packed, render.pile and render.simulate need convex parts, "
                "results/D/convex_parts/G.parquet"
            )
        opening = settings.gripper.opening
        if settings.render.widths and settings.render.widths[1] > opening:
            raise UserError(
                f"render.widths ends at {settings.render.widths[1]:g} m, but the gripper "
                f"opens {opening:g} m"
            )
        self.settings = settings
        self._body: HandBody = hand_body(settings.gripper)
        self._ids = dict(zip(objects["label"], objects["id"], strict=True))
        self._labels = dict(zip(objects["id"], objects["label"], strict=True))
        self._meshes = meshes
        table = parquet.read(convex_parts, CONVEX_PARTS) if convex_parts else pd.DataFrame()
        self._parts = dict(iter(table.groupby("label"))) if len(table) else {}
        self._known = lru_cache(KEPT)(self._read)

    def pictures(self, share: Share) -> Iterator[RenderedImage]:
        """The images of an object, or of a scene of several, or `RejectedError`."""
        simulate = self._simulate if self.settings.render.simulate else None
        if share.scene == "single":
            (label,) = share.members
            known = self._known(label)
            yield from pictures(known.mesh, share, self._body, self.settings, simulate)
            return
        key = (share.id,)
        labelled = first_good(
            lambda rng, _: self._arranged(share, rng), self._body, self.settings, key, simulate
        )
        if labelled is not None:
            yield from views_of(labelled, share, self.settings, key)

    def _arranged(self, share: Share, rng: np.random.Generator) -> tuple[PlacedObject, ...]:
        """The objects of a scene at random sizes, where they come to rest."""
        found = [self._known(label) for label in share.members]
        sizes = [self._size(each, share, rng) for each in found]
        pairs = [pair for pair in zip(found, sizes, strict=True) if pair[1] and pair[0].parts]
        if not pairs:
            return ()
        density = self.settings.material.density
        models = [model_at_size(each.mesh, each.parts, size, density) for each, size in pairs]
        placed = settle_scene(models, share.scene, self.settings.simulated_label.engine, rng)
        return tuple(
            place(each.id, each.mesh, each.com, size, matrix)
            for number, matrix in placed
            for each, size in [pairs[number]]
        )

    def _size(self, known: KnownObject, share: Share, rng: np.random.Generator) -> float:
        width = draw_width(self.settings, known.id, share.id)
        if width is None:
            return 1.0
        return sample_factor(known.caster, width, self.settings.sampling, rng)

    def _simulate(
        self, placed: PlacedObject, contacts: ContactPairs, approaches: Floats
    ) -> list[bool | None]:
        """Whether grasps hold; unknown for objects without convex parts."""
        if len(contacts) == 0:
            return []
        known = self._known(self._labels[placed.id])
        if not known.parts:
            return [None] * len(contacts)
        density = self.settings.material.density
        model = model_at_size(known.mesh, known.parts, placed.factor, density)
        return simulate_contacts(model, contacts, approaches, self.settings.labels)

    def _read(self, label: str) -> KnownObject:
        mesh = read_mesh(self._meshes / f"{label}.obj", "m")
        rows = self._parts.get(label)
        parts = () if rows is None else read_parts(rows)
        return KnownObject(self._ids[label], mesh, parts)


if __name__ == "__main__":
    run_job(run)
