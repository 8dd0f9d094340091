"""Objects as they are simulated, with their labelled grasps."""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.detectors import Detect, DetectorConfig, grasps_if_any, knows_scene
from egad.errors import RejectedError, UserError
from egad.grasps import GraspLabel, Grasps, label_parameters
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.sim import Model
from egad.sim.model import simulated
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

T = TypeVar("T")
# a seed to sample grasps with, or the grasps of each object by its id; None if they are not needed
Labelled: TypeAlias = int | Mapping[str, pd.DataFrame] | None

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
    targets: Sequence[NamedMesh], gripper: Gripper, rule: str, labelled: Labelled
) -> Mapping[str, SceneObject]:
    """Objects by id, made when they are looked up; RejectedError if one cannot be simulated."""
    return Lazy({each.id: partial(_made, each, gripper, rule, labelled) for each in targets})


def models_of(objects: Mapping[str, SceneObject]) -> Mapping[str, Model]:
    """The models of objects by id, each looked up when it is needed."""
    return Lazy({name: partial(_model, objects, name) for name in objects})


def _model(objects: Mapping[str, SceneObject], name: str) -> Model:
    return objects[name].model


def _made(
    target: NamedMesh,
    gripper: Gripper,
    rule: str,
    labelled: Labelled,
    grasps: int = GraspLabel().grasps,
) -> SceneObject:
    """An object as it is simulated, with grasps if they are needed."""
    mesh, model = simulated(target, gripper, rule)
    if labelled is None:
        return SceneObject(target.id, model, empty(GRASPS))
    if not isinstance(labelled, int):
        return SceneObject(target.id, model, labelled[target.id])
    labels = label_parameters(gripper, grasps, labelled)
    return SceneObject(target.id, model, grasps_if_any(mesh, target.id, labels))


def prepare_object(
    target: NamedMesh,
    gripper: Gripper,
    rule: str,
    labelled: Labelled,
    otherwise: str = "cannot be simulated",
    grasps: int = GraspLabel().grasps,
) -> SceneObject | None:
    """An object as it is simulated, with grasps if they are needed; None if it cannot."""
    try:
        return _made(target, gripper, rule, labelled, grasps)
    except RejectedError as reason:
        log.warning("%s %s: %s", target.label, otherwise, reason)
        return None


def prepare_objects(
    targets: Sequence[NamedMesh],
    gripper: Gripper,
    rule: str,
    labelled: Labelled = None,
    jobs: int = 1,
) -> list[SceneObject]:
    """Objects with grasps if they are needed; UserError if none can be simulated."""
    work = partial(
        prepare_object, rule=rule, gripper=gripper, labelled=labelled, otherwise="is left out"
    )
    with workers(jobs) as mapper:
        made = list(progress(mapper(work, targets), "making models", len(targets)))
    usable = [each for each in made if each is not None]
    if not usable:
        raise UserError("none of the objects can be simulated")
    return usable


def labels_from(
    grasps: Mapping[str, Grasps] | None, detect: Detect, rule: str, targets: Sequence[NamedMesh]
) -> Mapping[str, pd.DataFrame] | None:
    """Grasps by id from those by label, the argument of a public function; `UserError`."""
    if isinstance(detect, DetectorConfig) and detect.known_grasps:
        raise UserError(f"{detect.name}: in Python, give labels the `grasps` that are read from it")
    if grasps is None:
        return None
    if not knows_scene(detect):
        raise UserError("grasps are for the detector labels, which knows where the objects are")
    if rule != "none":
        raise UserError(f"rule is {rule!r}; with grasps, it is 'none': they are for one size")
    return dict(grasps_by_id(grasps, targets))


def grasps_by_id(
    grasps: Mapping[str, Grasps], targets: Sequence[NamedMesh]
) -> Mapping[str, pd.DataFrame]:
    """Grasps for the detector `labels`, from those by label; UserError if an object has none.

    What their file calls a failure is left out. Its scores, if none is missing, rank the others.
    """
    if missing := [each.label for each in targets if each.label not in set(grasps)]:  # not read
        known = ", ".join(grasps) or "nothing"
        raise UserError(f"there are no grasps of {missing[0]!r}; there are some of {known}")
    return Lazy({each.id: partial(_without_failures, grasps, each.label) for each in targets})


def _without_failures(grasps: Mapping[str, Grasps], label: str) -> pd.DataFrame:
    _ = grasps[label].quality  # an error if they were read without a mesh
    table = grasps[label].to_frame()
    score = table.get("source_score", pd.Series(np.nan, table.index))
    if score.notna().all():
        table = table.assign(robust_quality=score)
    return table[table["source_success"] != 0] if "source_success" in table else table
