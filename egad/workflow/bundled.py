"""Objects to simulate, from a bundle or as shipped, and work that may crash the physics engine."""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from egad.bench import Models
from egad.config import Settings
from egad.exchange import read_simulation_object
from egad.grippers import Gripper
from egad.objects import EVALUATION_SET, NamedMesh, load, named_meshes
from egad.sim import Model, model_of
from egad.sim.model import simulated
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE
from egad.tables.outcomes import Outcome

log = logging.getLogger(__name__)
ENGINE_TIME = 60.0  # seconds; an attempt takes less than one, unless the engine hangs
Row = Mapping[str, Any]
Item = TypeVar("Item")


def rows_by_id(bundle: Path) -> dict[str, Row]:
    """Columns of `tables.evaluation.BUNDLE` of each object in the folder of a bundle."""
    return {
        row["id"]: row for row in parquet.records(parquet.read(bundle / "bundle.parquet", BUNDLE))
    }


def model_in(bundle: Path, row: Row) -> Model:
    """An object of a simulation bundle, with the columns of `tables.evaluation.BUNDLE`."""
    made = read_simulation_object(bundle, row)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


class LazyModels(Mapping[str, Model]):
    """Objects to simulate by their ids; each is made when it is looked up."""

    def __init__(self, makers: Mapping[str, Callable[[], Model]]) -> None:
        """Take functions that make each object."""
        self._makers = dict(makers)
        self._made: dict[str, Model] = {}

    def __getitem__(self, name: str) -> Model:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)


def models_in(dataset: Path, settings: Settings, gripper: str) -> Models:
    """The objects that were used in trials of a dataset, a folder with a simulation bundle.

    Or `evaluation-set`: the released objects, as `egad benchmark` and `egad.run_trials` scale and
    simulate them.
    """
    if str(dataset) == EVALUATION_SET:
        return evaluation_set_models(settings.grippers[gripper], settings.rescale.rule)
    return bundle_models(dataset / "bundle" / gripper)


def bundle_models(bundle: Path) -> Models:
    """The objects in the folder of a simulation bundle."""
    rows = rows_by_id(bundle)
    return LazyModels({name: partial(model_in, bundle, row) for name, row in rows.items()})


def evaluation_set_models(gripper: Gripper, rule: str) -> Models:
    """The objects of the released evaluation set, scaled to a gripper."""
    return lazy_models(named_meshes(load(EVALUATION_SET)), gripper, rule)


def lazy_models(targets: Sequence[NamedMesh], gripper: Gripper, rule: str) -> Models:
    """Objects scaled to a gripper, as `egad benchmark` and `egad.run_trials` simulate them."""
    return LazyModels({each.id: partial(_simulated, each, gripper, rule) for each in targets})


def _simulated(target: NamedMesh, gripper: Gripper, rule: str) -> Model:
    return simulated(target, gripper, rule)[1]


def run_or_replace(
    row: Row,
    work: Callable[[Item], pd.DataFrame | None],
    item: Item | None,
    otherwise: Callable[[Outcome], pd.DataFrame],
) -> pd.DataFrame:
    """The table of the work on an object, or one whose attempts all have the same outcome.

    That is `crashed` if the work returns None, and `failed` if there is no item, as for an object
    that the bundle does not contain.
    """
    table = None if item is None else work(item)
    if table is not None:
        return table
    outcome = Outcome.FAILED if item is None else Outcome.CRASHED
    log.warning("%s (%s): everything %s", row["label"], row["id"], outcome)
    return otherwise(outcome)
