"""Objects as they are simulated, with their labelled grasps."""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.detectors import grasps_if_any
from egad.errors import RejectedError, UserError
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.sim import Model
from egad.sim.model import simulated
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

T = TypeVar("T")

log = logging.getLogger(__name__)


class Lazy(Mapping[str, T]):
    """Values by name; each is made once, when it is looked up."""

    def __init__(self, makers: Mapping[str, Callable[[], T]]) -> None:
        """Take a function for each value."""
        self._makers = dict(makers)
        self._made: dict[str, T] = {}

    def __getitem__(self, name: str) -> T:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)


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


def models_of(objects: Mapping[str, SceneObject]) -> Mapping[str, Model]:
    """The models of objects by id, each looked up when it is needed."""
    return Lazy({name: partial(_model, objects, name) for name in objects})


def _model(objects: Mapping[str, SceneObject], name: str) -> Model:
    return objects[name].model


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
