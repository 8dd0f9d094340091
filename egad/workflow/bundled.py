"""Objects of a simulation bundle, and work on them that may crash the physics engine."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from egad.exchange import read_simulation_object
from egad.outcomes import Outcome
from egad.sim import Model, model_of
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE

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
    """An object of a simulation bundle.

    Args:
        bundle: Its folder.
        row: Columns of `tables.evaluation.BUNDLE`.
    """
    made = read_simulation_object(bundle, row)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def outlived(
    row: Row,
    work: Callable[[Item], pd.DataFrame | None],
    item: Item | None,
    otherwise: Callable[[Outcome], pd.DataFrame],
) -> pd.DataFrame:
    """The result of the work on an object, also if the engine crashes.

    Args:
        row: Label and id of the object.
        work: Returns the table of the item, or None if the process crashed.
        item: Argument of the work; None if the object is not in the bundle.
        otherwise: Returns the table of an object whose attempts all have the given outcome.
    """
    table = None if item is None else work(item)
    if table is not None:
        return table
    outcome = Outcome.FAILED if item is None else Outcome.CRASHED
    log.warning("%s (%s): everything %s", row["label"], row["id"], outcome)
    return otherwise(outcome)
