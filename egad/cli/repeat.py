"""What is needed to repeat simulated attempts: from options, or as noted in their table."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad.cli.common import (
    FIRST_TARGET,
    RUN,
    gripper_option,
    named_gripper,
    objects_in,
    settings_in,
)
from egad.config import Settings
from egad.grippers import Gripper

if TYPE_CHECKING:
    from egad.sim import ClutterParameters, Models, TrialParameters

NOTE = "run"
OF_TABLE = "that of the table"
SimulatedIn = Annotated[
    Path | None,
    typer.Option(
        "--in",
        help="folder of the dataset, or `evaluation-set` for tables of `egad.run_trials`; default: "
        f"{OF_TABLE} of `egad trials run` or `egad benchmark`, else {RUN}",
    ),
]
RunGripper = Annotated[
    str | None, gripper_option(f"{OF_TABLE}, else {FIRST_TARGET}", opening=False)
]


def note_of_run(
    settings: "TrialParameters | ClutterParameters",
    rule: str,
    gripper: str,
    objects: str,
    units: str | None,
) -> dict[str, Any]:
    """The note of a table from which its attempts can be repeated; see `repeatable`."""
    values = settings.model_dump(mode="json", exclude={"detector", "gripper"})
    hand = settings.gripper.model_dump(mode="json")
    named = {"objects": objects, "units": units, "gripper": gripper, "hand": hand}
    return {NOTE: {**named, "settings": {**values, "rescale": {"rule": rule}}}}


def repeatable(
    table: Path, dataset: Path | None, gripper: str | None, config: Path | None
) -> tuple[Settings, str, "Models"]:
    """Settings, name of the gripper and objects of the attempts in a table.

    They are those noted in the table, unless `--in`, `--gripper` or `--config` is given.
    """
    from egad.config.check import check
    from egad.config.files import defaults, merged
    from egad.tables import parquet
    from egad.workflow.bundled import lazy_models, models_in

    noted = parquet.notes(table).get(NOTE)
    if noted is None or any(each is not None for each in (dataset, gripper, config)):
        settings, hand = named_gripper(settings_in(config), gripper)
        return settings, hand, models_in(dataset or RUN, settings, hand)
    hand = noted["gripper"]
    known = Gripper.model_validate(noted["hand"])
    settings = check(merged(defaults(), noted["settings"]))
    settings = settings.model_copy(update={"grippers": {**settings.grippers, hand: known}})
    targets, _ = objects_in(noted["objects"], noted["units"])
    return settings, hand, lazy_models(targets, known, settings.rescale.rule)
