"""The network that an object was grown from."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common


def genome(
    name: Annotated[str, typer.Argument(help="label or id of an object, or id of an ancestor")],
    source: Annotated[
        str, typer.Option("--in", help="`released`, archive.parquet, or folder of a dataset")
    ] = "released",
    out: Annotated[Path | None, common.out_option("drawing to write as well: .svg")] = None,
    digits: Annotated[
        int | None,
        typer.Option(min=1, max=17, help="significant digits; default: as many as shapes need"),
    ] = None,
    config: common.Config = None,
) -> None:
    """Print the network that an object was grown from as expressions, and draw it."""
    from egad._util.files import write_text
    from egad.evolution import genome_text
    from egad.io import check_ending
    from egad.objects import load
    from egad.report.genome_drawing import genome_svg

    check_ending(out, (".svg",))
    objects, settings = load(source), common.settings_in(config)
    if name not in objects and name in objects.lineage:
        row = objects.lineage.genome(name)
    else:
        row = objects[name].genome
    if out is not None:
        write_text(out, genome_svg(row))
    regions = {each: getattr(settings, each) for each in ("envelope", "keep_solid", "hole")}
    shape, symmetry = objects.shape, settings.symmetry
    text = genome_text(row, digits=digits, shape=shape, symmetry=symmetry, regions=regions)
    typer.echo(text, nl=False)
