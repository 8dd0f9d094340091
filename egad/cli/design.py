"""Fingertips for a hand, searched in simulation."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common
from egad.cli.hands import hand_in

ENGINES = ["mujoco", "pybullet"]


def design(
    base: Annotated[
        str,
        typer.Argument(metavar="BASE", help="gripper of the configuration, file, or opening"),
    ],
    space: Annotated[
        Path,
        typer.Option(help="YAML file: ranges of the dimensions, limits, size of the search, seed"),
    ],
    out: common.OutFolder,
    objects: common.Objects = "evaluation-set",
    units: common.Units = None,
    engines: Annotated[
        list[str],
        typer.Option("--engine", help="physics engine that the tips are judged in; repeatable"),
    ] = ENGINES,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Design fingertips for a hand: search, print, and compare the hand before and after."""
    from egad._util.parameters import from_file
    from egad.bench.tips import TipSearch, design_tips
    from egad.grippers import files_of
    from egad.report.tips import write_tip_pages
    from egad_workflow.config_files import read_values
    from egad_workflow.provenance import recorded

    search = from_file(TipSearch, read_values(space))
    name, hand = hand_in(common.settings_in(config), base)
    targets, files = common.objects_in(objects, units)
    rule = "none" if common.are_meshes(files) else "paper"
    inputs = [*files, *files_of(hand)]
    with recorded("design", settings=search, inputs=inputs, arguments={"base": name}):
        tips = design_tips(name, hand, search, targets, out, rule=rule, engines=engines, jobs=jobs)
        for engine, card in tips.cards.items():
            card.save(out / f"card-{engine}.parquet")
    write_tip_pages(tips, out, targets, jobs=jobs)
    for card in tips.cards.values():
        for sentence in card.conclusions():
            typer.echo(sentence)
    typer.echo(f"{out}: the tips, the hand with them, cards, and datasheet.md")
