"""Trials that can be repeated: a note in their table says how, and options override it."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

import typer

from egad.cli import common
from egad.errors import UserError, check_name
from egad.grippers import Gripper
from egad_workflow.settings import Settings

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from egad.bench import ClearedTables, Models, SimulatedTrials
    from egad.bench.benchmark import Benchmark
    from egad.bench.trials import Trials
    from egad.objects import NamedMesh

NOTE = "run"
Result = TypeVar("Result", "Trials", "Benchmark")
OF_TABLE = "that of the table"
SimulatedIn = Annotated[
    Path | None,
    typer.Option(
        "--in",
        help="folder of the dataset, or `evaluation-set` for tables of `egad.run_trials`; default: "
        f"{OF_TABLE} of `egad trials run` or `egad benchmark`, else {common.RUN}",
    ),
]
RunGripper = Annotated[
    str | None, common.gripper_option(f"{OF_TABLE}, else {common.FIRST_TARGET}", opening=False)
]


def run_trials(
    command: str,
    work: Callable[[list["NamedMesh"], "Mapping[str, pd.DataFrame] | None"], Result],
    settings: "SimulatedTrials | ClearedTables",
    rule: str,
    gripper: str,
    objects: tuple[str, str | None],
    out: tuple[Path, "pa.Schema"],
) -> Result:
    """Simulate trials of `--objects` with `--units`; write the table, and a note to repeat it."""
    from egad.detectors import keep_failure
    from egad.exchange.known_grasps import known_grasps
    from egad.tables import parquet
    from egad_workflow.provenance import recorded

    targets, files = common.objects_in(*objects)
    known = settings.detector.known_grasps
    if known and rule != "none" and common.are_meshes(files):
        raise UserError(f"--rule is {rule}; with grasps of meshes it is none: they have one size")
    labels, read = known_grasps(known, targets, settings.gripper, rule) if known else (None, [])
    labels = labels and dict(labels)  # an error in a file comes before anything is simulated
    path, schema = out
    arguments = {"objects": Path(objects[0]).name, "rule": rule}
    values = settings.model_dump(mode="json", exclude={"detector", "gripper"})
    hand = settings.gripper.model_dump(mode="json")
    named = {"objects": objects[0], "units": objects[1], "gripper": gripper, "hand": hand}
    note = {NOTE: {**named, "settings": {**values, "rescale": {"rule": rule}}}}
    with (
        recorded(command, settings=settings, inputs=files + read, arguments=arguments),
        keep_failure(path),
    ):
        path.parent.mkdir(exist_ok=True)
        result = work(targets, labels)
        parquet.write(result.table, schema, path, note)
    return result


def _models_in(dataset: Path, settings: Settings, gripper: str) -> "Models":
    """The objects of the trials of a dataset, a folder with a bundle, or of `evaluation-set`."""
    from egad.exchange import bundle_models, evaluation_set_models
    from egad.objects import EVALUATION_SET

    if str(dataset) == EVALUATION_SET:
        return evaluation_set_models(settings.grippers[gripper], settings.rescale.rule)
    return bundle_models(dataset / "bundle" / gripper)


def repeatable_in(
    kind: Literal["trials", "clutter"],
    detector: str | None,
    table: Path | None,
    dataset: Path | None,
    gripper: str | None,
    config: Path | None,
) -> tuple[Path, Settings, str, "Models"]:
    """A table, and what `repeatable` says of it; without one, that of a detector of a run."""
    if table is not None:
        return table, *repeatable(table, dataset, gripper, config)

    settings, hand = common.named_gripper(common.settings_in(config), gripper)
    targets = settings.targets.clutter if kind == "clutter" else settings.targets.detectors
    if detector is None and not targets:
        raise UserError("--detector is missing: the configuration has no targets.clutter")
    detector = detector or targets[0]
    check_name("--detector", detector, settings.detectors, " in the configuration (--config)")
    table = (dataset or common.RUN) / kind / hand / f"{detector}.parquet"
    return table, settings, hand, _models_in(dataset or common.RUN, settings, hand)


def repeatable(
    table: Path, dataset: Path | None, gripper: str | None, config: Path | None
) -> tuple[Settings, str, "Models"]:
    """Settings, gripper and objects in the note of a table; each option replaces its part."""
    from egad.exchange import lazy_models
    from egad.tables import parquet
    from egad_workflow.check import check
    from egad_workflow.config_files import defaults, merged

    note = parquet.notes(table).get(NOTE)
    if note is None:
        settings, hand = common.named_gripper(common.settings_in(config), gripper)
        return settings, hand, _models_in(dataset or common.RUN, settings, hand)
    settings = common.settings_in(config) if config else check(merged(defaults(), note["settings"]))
    if gripper is None:
        hand = note["gripper"]
        grippers = {**settings.grippers, hand: Gripper.model_validate(note["hand"])}
        settings = settings.model_copy(update={"grippers": grippers})
    else:
        settings, hand = common.named_gripper(settings, gripper)
    if dataset is not None:
        return settings, hand, _models_in(dataset, settings, hand)
    try:
        targets, _ = common.objects_in(note["objects"], note["units"])
    except UserError as error:
        raise UserError(f"{table}: {error}; run it in the folder of the run") from error
    return settings, hand, lazy_models(targets, settings.grippers[hand], settings.rescale.rule)
