"""Hands compared on the same objects: a report card."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli import common
from egad.grippers import Gripper
from egad_workflow.settings import Settings

if TYPE_CHECKING:
    from egad.bench.hands import HandComparison


def hands(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="HAND...",
            help="grippers of the configuration, URDF or MJCF files, or openings in metres; "
            "differences are to the first",
        ),
    ],
    out: Annotated[
        Path,
        common.out_option("page to write: .html; the attempts are written beside it: .parquet"),
    ] = Path("hands.html"),
    objects: common.Objects = "evaluation-set",
    units: common.Units = None,
    size: Annotated[
        float,
        typer.Option(
            help="opening that evolved objects are scaled to, the same for all hands; meshes of "
            "your own keep their size"
        ),
    ] = 0.06,
    detector: Annotated[
        str | None,
        typer.Option(
            help="a detector that also chooses grasps, as for `egad benchmark`; default: "
            "antipodal-depth for jaws, suction-depth for cups"
        ),
    ] = None,
    weights: common.Weights = None,
    command: common.Command = None,
    engine: Annotated[str, typer.Option(help="physics engine: mujoco, pybullet or drake")] = (
        "mujoco"
    ),
    drops: Annotated[
        int, typer.Option(min=1, help="drops of each object that hands are judged on")
    ] = 6,
    errors: Annotated[
        str, typer.Option(help="errors of a real cell, the same for all hands: none or typical")
    ] = "typical",
    seed: Annotated[int, typer.Option(min=0, help="seed of everything random")] = 0,
    films: Annotated[
        int,
        typer.Option(min=0, help="films for each hand, of objects that it never holds"),
    ] = 3,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Compare hands: what each can hold, how easily, with a detector, and what it never holds."""
    from egad._util.parameters import from_arguments
    from egad.bench.hands import HandParameters, HandTrials, check_distinct, compare_at
    from egad.detectors import keep_failure
    from egad.grippers import files_of
    from egad.io import check_ending
    from egad.report.hands import write_card
    from egad.sim import check_engine
    from egad_workflow.provenance import recorded

    check_ending(out, (".html",))
    check_engine(engine)
    settings = common.settings_in(config)
    named = [hand_in(settings, text) for text in names]
    check_distinct([name for name, _ in named])
    compared = dict(named)
    detect = None
    if detector is not None or command is not None or weights is not None:
        settings, chosen = common.detector_in(settings, detector or "detector", weights, command)
        detect = settings.detectors[chosen]
    targets, files = common.objects_in(objects, units)
    rule = "none" if common.are_meshes(files) else "paper"
    values = {"size": size, "engine": engine, "drops": drops, "errors": errors}
    trials = from_arguments(HandTrials, **values)
    chosen_settings = from_arguments(HandParameters, seed=seed, hands=trials)
    table = out.with_suffix(".parquet")
    arguments = {"objects": Path(objects).name, "hands": ", ".join(compared)}
    inputs = [*files, *(file for hand in compared.values() for file in files_of(hand))]
    with (
        recorded("hands", settings=chosen_settings, inputs=inputs, arguments=arguments),
        keep_failure(table),
    ):
        card = compare_at(compared, targets, detect, chosen_settings, rule, jobs)
        card.save(table)
    write_card(card, out, targets, films=films, jobs=jobs)
    _tell(card)
    typer.echo(f"{out}: the card; {table}: the attempts")


def hand_in(settings: Settings, text: str) -> tuple[str, Gripper]:
    """A hand of a command line, and its name: that of its file, if it is one."""
    if Path(text).is_file():
        return Path(text).stem, Gripper.from_file(text)
    settings, name = common.gripper_in(settings, text)
    return name, settings.grippers[name]


def _tell(card: "HandComparison") -> None:
    """Print success rates, ranks and what they show."""
    from egad.cli.terminal_tables import hand_rates
    from egad.tables.hands import GRASPERS

    hand_rates({GRASPERS[who]: card.rates(who) for who in GRASPERS})
    for name in card.hands:
        lost = card.never_held(name)["label"].unique()
        typer.echo(f"{name} never holds {', '.join(lost) if len(lost) else 'none of the objects'}")
    for sentence in card.conclusions():
        typer.echo(sentence)
