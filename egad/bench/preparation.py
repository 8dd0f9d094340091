"""Objects as they are simulated, with their labelled grasps."""

import logging
from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.lazy import Lazy
from egad.detectors import grasps_if_any
from egad.errors import RejectedError, UserError
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.sim import Model
from egad.sim.model import simulated
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

log = logging.getLogger(__name__)


class SceneObject(NamedTuple):
    """An object as it is simulated, and its labelled grasps, none if they are not needed."""

    id: str
    model: Model
    grasps: pd.DataFrame


def lazy_objects(
    targets: Sequence[NamedMesh], gripper: Gripper, rule: str, label_seed: int | None
) -> Mapping[str, SceneObject]:
    """Objects by id, made when they are looked up; RejectedError if one cannot be simulated."""
    return Lazy({each.id: partial(_made, each, gripper, rule, label_seed) for each in targets})


def _made(
    target: NamedMesh,
    gripper: Gripper,
    rule: str,
    label_seed: int | None,
    grasps: int = GraspLabel().grasps,
) -> SceneObject:
    """An object as it is simulated, with grasps if there is a seed for them."""
    mesh, model = simulated(target, gripper, rule)
    if label_seed is None:
        return SceneObject(target.id, model, empty(GRASPS))
    labels = label_parameters(gripper, grasps, label_seed)
    return SceneObject(target.id, model, grasps_if_any(mesh, target.id, labels))


def prepare_object(
    target: NamedMesh,
    gripper: Gripper,
    rule: str,
    label_seed: int | None,
    otherwise: str = "cannot be simulated",
    grasps: int = GraspLabel().grasps,
) -> SceneObject | None:
    """An object as it is simulated, with grasps if there is a seed for them; None if it cannot."""
    try:
        return _made(target, gripper, rule, label_seed, grasps)
    except RejectedError as reason:
        log.warning("%s %s: %s", target.label, otherwise, reason)
        return None


def prepare_objects(
    targets: Sequence[NamedMesh],
    gripper: Gripper,
    rule: str,
    label_seed: int | None = None,
    jobs: int = 1,
) -> list[SceneObject]:
    """Objects with grasps if there is a seed for them; UserError if none can be simulated."""
    work = partial(
        prepare_object, rule=rule, gripper=gripper, label_seed=label_seed, otherwise="is left out"
    )
    with workers(jobs) as mapper:
        made = list(progress(mapper(work, targets), "making models", len(targets)))
    usable = [each for each in made if each is not None]
    if not usable:
        raise UserError("none of the objects can be simulated")
    return usable
