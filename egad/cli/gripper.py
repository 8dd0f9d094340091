"""Tools for grippers."""

import re
from collections.abc import Collection, Mapping
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli import common
from egad.errors import UserError, check_name

if TYPE_CHECKING:
    from egad.grippers import Gripper

gripper = typer.Typer(
    name="gripper", no_args_is_help=True, help="Grippers from URDF and MJCF files: inspect."
)


@gripper.callback()
def _group() -> None:
    """Keep `inspect` a subcommand."""


@gripper.command()
def inspect(
    hand: Annotated[
        str,
        typer.Argument(
            metavar="FILE|NAME", help="URDF or MJCF file, or a gripper of the configuration"
        ),
    ],
    out: Annotated[
        Path | None, common.out_option("page to write: .html; default: NAME.html")
    ] = None,
    config: common.Config = None,
) -> None:
    """Show what is found in the file of a hand: joints, fingers, pads, opening, shape in 3D.

    For a suction cup, it shows what the cup holds.

    Prints the entry for a configuration. Writes NAME.html, or the page given by --out.
    """
    from egad.grippers import Gripper
    from egad.grippers.kinds import CupKind, JawKind
    from egad.io import check_ending

    check_ending(out, (".html",))
    if Path(hand).is_file():
        name = _name_of(Path(hand), common.settings_in(config).grippers)
        chosen = Gripper.from_file(hand)
    else:
        known = common.with_packaged(common.settings_in(config), hand).grippers
        name = check_name("gripper or file", hand, known)
        chosen = known[name]
    describe = {JawKind.name: _describe_hand, CupKind.name: _describe_cup}[chosen.kind.name]
    _write(out, name, *describe(name, chosen))


def _describe_cup(name: str, hand: "Gripper") -> tuple[dict[str, str], str, str]:
    """Facts about a cup, its entry in a configuration, and its page."""
    from egad.grippers import cup_of
    from egad.report.hand import cup_entry, cup_facts, cup_page

    cup = cup_of(hand, "its page")
    return cup_facts(cup), cup_entry(name, hand), cup_page(name, hand, cup)


def _describe_hand(name: str, hand: "Gripper") -> tuple[dict[str, str], str, str]:
    """The same for a hand from a file."""
    from egad.grippers import model_of
    from egad.report.hand import hand_entry, hand_facts, hand_page, jaw_table

    if hand.file is None:
        raise UserError(f"the gripper {name} has no `file`; its boxes are in the configuration")
    model = model_of(hand)
    facts = hand_facts(hand, model)
    for row in jaw_table(model):
        cells = (row[key] for key in ("opening", "angle", "friction", "gaps"))
        text = "opening {}, angle {}, friction {}; gaps {} mm".format(*cells)
        facts[f"joint at {row['joint']}"] = text
    return facts, hand_entry(name, hand, model), hand_page(name, hand, model)


def _write(out: Path | None, name: str, facts: Mapping[str, str], entry: str, page: str) -> None:
    from egad._util.files import write_text

    for key, value in facts.items():
        typer.echo(f"{key + ':':38s} {value}")
    typer.echo(f"\n{entry}")
    path = out or Path(f"{name}.html")
    write_text(path, page)
    typer.echo(f"see {path}")


def _name_of(path: Path, taken: Collection[str]) -> str:
    """A name for the gripper of a file, which no other gripper has."""
    from egad.grippers import GRIPPERS, PACKAGED

    name = re.sub(r"[^a-z0-9_-]+", "_", path.stem.lower()).strip("_-") or "hand"
    names = chain([name, f"my_{name}"], (f"my_{name}_{number}" for number in count(2)))
    return next(each for each in names if each not in {*GRIPPERS, *PACKAGED, *taken})
