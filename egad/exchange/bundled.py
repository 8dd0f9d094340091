"""Objects to simulate: those of a bundle, of a dataset, or as shipped."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from egad.bench import Models
from egad.bench.preparation import Lazy
from egad.errors import RejectedError, UserError
from egad.exchange.objects.simulation import read_simulation_object
from egad.grippers import Gripper
from egad.io import read_mesh
from egad.objects import EVALUATION_SET, NamedMesh, load, named_meshes
from egad.sim import Model, model_of, simulation_object
from egad.sim.model import simulated
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE


def rows_by_id(bundle: Path) -> dict[str, Mapping[str, Any]]:
    """Columns of `tables.evaluation.BUNDLE` of each object in the folder of a bundle."""
    return {
        row["id"]: row for row in parquet.records(parquet.read(bundle / "bundle.parquet", BUNDLE))
    }


def model_in(bundle: Path, row: Mapping[str, Any]) -> Model:
    """An object of a simulation bundle, with the columns of `tables.evaluation.BUNDLE`."""
    made = read_simulation_object(bundle, row)
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def model_of_parts(path: Path, density: float, parts: pd.DataFrame) -> Model:
    """A scaled object, its mesh file and the rows of its convex parts: `UserError` if damaged."""
    try:
        made = simulation_object(read_mesh(path, "m"), density, parts)
    except RejectedError as reason:
        raise UserError(f"{path}: {reason}") from reason
    return model_of(made.mesh, made.parts, made.physics, made.volume_error)


def bundle_models(bundle: Path) -> Models:
    """The objects in the folder of a simulation bundle."""
    rows = rows_by_id(bundle)
    return Lazy({name: partial(model_in, bundle, row) for name, row in rows.items()})


def evaluation_set_models(gripper: Gripper, rule: str) -> Models:
    """The objects of the released evaluation set, scaled to a gripper."""
    return lazy_models(named_meshes(load(EVALUATION_SET)), gripper, rule)


def lazy_models(targets: Sequence[NamedMesh], gripper: Gripper, rule: str) -> Models:
    """Objects scaled to a gripper, as `egad benchmark` and `egad.run_trials` simulate them."""
    return Lazy({each.id: partial(_simulated, each, gripper, rule) for each in targets})


def _simulated(target: NamedMesh, gripper: Gripper, rule: str) -> Model:
    return simulated(target, gripper, rule)[1]
