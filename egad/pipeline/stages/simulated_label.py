"""simulated-label: labelled grasps of the objects of a shard, closed, shaken and lifted."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated

import pandas as pd
import trimesh

from egad._util.child_process import Survivor
from egad._util.progress import phase, progress
from egad.errors import RejectedError, UserError
from egad.evalset import simulation_object
from egad.exchange import read_mesh
from egad.outcomes import Outcome
from egad.pipeline.config import Material
from egad.pipeline.parameters import Input, Output, command
from egad.pipeline.stages.bundled import ENGINE_TIME
from egad.sim import (
    SimulatedGrasp,
    SimulatedLabelParameters,
    chosen_grasps,
    model_of,
    simulate_labels,
    with_simulated_labels,
)
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import GRASPS, SIMULATED_GRASPS

log = logging.getLogger(__name__)


class SimulatedLabels(SimulatedLabelParameters):
    """Simulated labels of the grasps of a gripper."""

    material: Material


@command()
def run(
    settings: SimulatedLabels,
    grasps: Annotated[Path, Input()],
    convex_parts: Annotated[Path, Input()],
    meshes: Annotated[Path, Input()],
    out: Annotated[Path, Output()],
) -> None:
    """Simulate the grasps of the objects of a shard: closed in free space, shaken and lifted.

    Everything runs in a separate process. If an object crashes it twice, its grasps are marked as
    crashed.

    Args:
        settings: Settings of this stage.
        grasps: Labelled grasps of the shard.
        convex_parts: Convex parts of its objects.
        meshes: Folder of the scaled meshes.
        out: The same grasps with the columns of `tables.grasping.SIMULATED_GRASPS`.
    """
    labelled = parquet.read(grasps, GRASPS)
    found = []
    phase("starting the simulator")
    limit = ENGINE_TIME * settings.simulated_label.grasps
    objects = labelled.groupby("label")
    with Survivor(partial(simulator, settings, convex_parts, meshes), limit) as simulate:
        for _, rows in progress(objects, "simulating grasps", objects.ngroups):
            labels = simulate(rows)
            found.append(_failed(rows, settings, Outcome.CRASHED) if labels is None else labels)
    whole = pd.concat(found) if found else parquet.empty(SIMULATED_GRASPS)
    parquet.write(whole, SIMULATED_GRASPS, out)
    known = whole["simulated_success"].dropna()
    log.info("%d grasps simulated, %d held", len(known), int(known.sum()))


@contextmanager
def simulator(
    settings: SimulatedLabels, convex_parts: Path, meshes: Path
) -> Iterator[Callable[[pd.DataFrame], pd.DataFrame]]:
    """A function that adds simulated labels to the grasps of an object."""
    parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))

    def simulate(rows: pd.DataFrame) -> pd.DataFrame:
        label = rows["label"].iloc[0]
        mesh = _read(meshes / f"{label}.obj")
        if label not in parts:
            log.warning("%s cannot be simulated: it has no convex parts", label)
            return _failed(rows, settings, Outcome.FAILED)
        made = simulation_object(mesh, settings.material.density, parts[label])
        model = model_of(made.mesh, made.parts, made.physics, made.volume_error)
        return simulate_labels(model, rows, settings)

    yield simulate


def _read(path: Path) -> trimesh.Trimesh:
    """A mesh that an earlier stage wrote: if it cannot be read, the folder is broken."""
    try:
        return read_mesh(path, "m")
    except RejectedError as reason:
        raise UserError(f"{path}: {reason}") from reason


def _failed(rows: pd.DataFrame, settings: SimulatedLabels, outcome: Outcome) -> pd.DataFrame:
    chosen = chosen_grasps(rows, settings)
    return with_simulated_labels(rows, chosen, [SimulatedGrasp(outcome)] * len(chosen), settings)
