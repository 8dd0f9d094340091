"""A page to log grasp attempts with a real robot."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli import common
from egad.errors import UserError, check_name

if TYPE_CHECKING:
    from egad.objects import EvolvedObject

ATTEMPTS = 20  # as in the paper
SIZE = 256


def log_sheet(
    dataset: Annotated[
        Path,
        typer.Argument(
            help="folder of a dataset with an evaluation set, e.g. results/egad; or "
            "`evaluation-set`: that of the released objects"
        ),
    ],
    detectors: Annotated[str, typer.Option(help="names of the detectors, separated by commas")],
    gripper: Annotated[str, common.gripper_option()] = "egad_75mm",
    attempts: Annotated[
        int, typer.Option(min=1, help="attempts of each detector at each object")
    ] = ATTEMPTS,
    out: Annotated[
        list[Path],
        common.out_option("file to write: .html, the page; .csv, the order; may be repeated"),
    ] = [Path("log.html")],  # noqa: B006 (typer copies it)
    seed: Annotated[int, typer.Option(min=0, help="random seed of the order")] = 0,
    blind: Annotated[
        bool, typer.Option("--blind", help="call the detectors A, B, ... until the end")
    ] = False,
    rounds: Annotated[
        bool,
        typer.Option(
            "--rounds",
            help="try every object once before any is tried again, to look at results early",
        ),
    ] = False,
    objects: Annotated[
        str | None, typer.Option(help="labels of the objects, separated by commas; default: all")
    ] = None,
    config: common.Config = None,
) -> None:
    """Write a page for a phone or a computer to log attempts with a real robot; works offline.

    The gripper decides which outcomes it offers: those of jaws or of a suction cup.
    `egad trials report` and `compare` read the CSV file that the page exports.
    """
    from egad._util.files import atomic_output, write_text
    from egad._util.progress import progress
    from egad.io import check_ending
    from egad.report.log_sheet import LogObject, order_table, page, plan
    from egad.report.pictures import png_bytes, render
    from egad.tables.outcomes import observable

    for path in out:
        check_ending(path, (".html", ".csv"))
        if path.suffix.lower() == ".csv" and path.exists():
            raise UserError(f"--out {path} exists and may already be filled in; give another file")
    settings, hand = common.gripper_in(common.settings_in(config), gripper)
    outcomes = observable(cup=not settings.grippers[hand].kind.closes)
    found = evaluation_objects(dataset, None if objects is None else _words(objects))
    planned = plan(found, attempts, _words(detectors), seed, blind=blind, rounds=rounds)
    tried = [
        LogObject(label, item.id, png_bytes(render(item.mesh, SIZE)))
        for label, item in progress(found.items(), "drawing", len(found))
    ]
    for path in out:
        if path.suffix.lower() == ".html":
            write_text(path, page(planned, tried, str(dataset), outcomes))
        else:
            with atomic_output(path) as temporary:
                order_table(planned, tried).to_csv(temporary, index=False)
    typer.echo(f"{len(planned.order)} attempts at {len(tried)} objects; see {out[0]}")


def evaluation_objects(dataset: Path, labels: list[str] | None) -> "dict[str, EvolvedObject]":
    """Chosen objects of an evaluation set by their labels in it, in the order of the set."""
    from egad.objects import EVALUATION_SET, RELEASED, load
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    table = dataset / "eval49.parquet"
    if str(dataset) in (EVALUATION_SET, RELEASED):
        source = load(EVALUATION_SET)
        ids = dict(zip(source.table["label"], source.table["id"], strict=True))
    elif table.is_file():
        chosen = parquet.read(table, EVAL49)
        ids, source = dict(zip(chosen["label"], chosen["id"], strict=True)), load(dataset)
    else:
        raise UserError(
            f"{table} is missing; make it with: snakemake --cores 2 {table}, or give "
            f"{EVALUATION_SET} for the released objects"
        )
    wanted = list(ids) if labels is None else labels
    for label in wanted:
        check_name("--objects:", label, ids, " in the evaluation set")
    if not wanted:
        raise UserError("--objects names no object")
    return {label: source[ids[label]] for label in ids if label in wanted}


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()]
