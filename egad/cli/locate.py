"""The position of meshes among the objects of a dataset, and their nearest objects."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli import common
from egad.cli.measure import measure_row, warn_of_measures
from egad.errors import UserError
from egad.measures import MeasureMeshes
from egad_workflow.settings import select

if TYPE_CHECKING:
    import pandas as pd
    import trimesh

    from egad.measures.reeb import Neighborhood
    from egad.objects import Dataset
    from egad.report.locations import Located

PORTRAIT, THUMBNAIL = 192, 96


def locate(
    meshes: common.Meshes,
    among: Annotated[
        Path, typer.Option("--in", help="archive.parquet, `released`, or folder of a dataset")
    ],
    units: common.Units = None,
    out: Annotated[
        list[Path], common.out_option("file to write: .html, .parquet or .csv; may be repeated")
    ] = [Path("locate.html")],  # noqa: B006 (typer copies it)
    max_candidates: common.MaxCandidates = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Show the positions of meshes in the space of a dataset, and the most similar objects."""
    from egad._util.files import write_text
    from egad.cli.table_files import write_frame
    from egad.cli.terminal_tables import located
    from egad.io import check_ending, object_names
    from egad.report.axes import axis_pair
    from egad.report.locations import page
    from egad.tables.objects import LOCATED

    for path in out:
        check_ending(path, (".html", ".parquet", ".csv"))
    options = {"--max-candidates": ("postprocess.max_candidates", max_candidates)}
    settings = select(common.settings_in(config, options), MeasureMeshes)
    objects = reference(among, settings)
    files = object_names(common.files_in(meshes, units))
    table, shown = locate_files(settings, objects, files, units, jobs)
    reasons, axes = common.reasons_in(table), axis_pair(settings.measures)
    for path in out:
        if path.suffix.lower() == ".html":
            text = page(str(among), objects.table, shown, reasons, settings.space, axes)
            write_text(path, text)
        else:
            write_frame(table, LOCATED, path)
    located(table, axes)
    common.complain(reasons, len(table))


def reference(source: Path, settings: MeasureMeshes) -> "Dataset":
    """The objects to compare with, see `egad.load`; UserError if made with a finer grid."""
    from egad.objects import load

    found = load(str(source))
    cells = found.table[["complexity_cell", "difficulty_cell"]].to_numpy()
    if len(cells) and cells.max() >= settings.space.cells:
        raise UserError(
            f"--in {source} has cells up to {cells.max()}, but the configuration has "
            f"{settings.space.cells} along each axis; give the configuration of that "
            "dataset with --config"
        )
    return found


def locate_files(
    settings: MeasureMeshes,
    among: "Dataset",
    files: Mapping[str, Path],
    units: str | None,
    worker_count: int,
) -> "tuple[pd.DataFrame, list[Located]]":
    """Rows of `tables.objects.LOCATED` of all meshes, and contents of the page of usable ones."""
    import pandas as pd

    from egad.cli.released_graphs import dataset_graphs
    from egad.io import warn_of_units
    from egad.measures.reeb import Neighborhood
    from egad.measures.reeb import graph as reeb
    from egad.tables.objects import LOCATED, MEASURED

    similarity = settings.similarity
    with workers(worker_count) as mapper:
        work = partial(_mine, units=units, settings=settings)
        mine = list(progress(mapper(work, files.items()), "measuring", len(files)))
        packed = dataset_graphs(among, similarity, mapper)
    hood = Neighborhood(similarity.weight, settings.space.neighbors)
    hood.add(reeb.unpack(graph) for graph in packed)  # indices are those of the rows
    rows = [_placed(item, hood, among.table) for item in mine]
    warn_of_units({item.row["name"]: item.longest for item in mine}, units)
    warn_of_measures(pd.DataFrame([item.row for item in mine], columns=MEASURED.names))
    return pd.DataFrame(rows, columns=LOCATED.names), [
        _located(row, item, among) for row, item in zip(rows, mine, strict=True) if item.graph
    ]


class _Mine(NamedTuple):
    """A mesh of the user: its row, longest side, and packed graph and picture if it is usable."""

    row: dict[str, Any]
    longest: float
    graph: bytes = b""
    picture: bytes = b""


def _mine(item: tuple[str, Path], units: str | None, settings: MeasureMeshes) -> _Mine:
    from egad.io import use_mesh
    from egad.measures.reeb import graph as reeb
    from egad.report.pictures import png_bytes, render

    def use(mesh: "trimesh.Trimesh") -> tuple[dict[str, Any], bytes, bytes]:
        solid, row = measure_row(mesh, settings)
        graph = reeb.pack(reeb.extract(solid, settings.similarity))
        return row, graph, png_bytes(render(solid, PORTRAIT))

    name, path = item
    found, longest = use_mesh(path, units, use)
    if isinstance(found, str):
        return _Mine({"name": name, "reason": found}, longest)
    row, graph, picture = found
    return _Mine({"name": name, "reason": "", **row}, longest, graph, picture)


def _placed(item: _Mine, hood: "Neighborhood", objects: "pd.DataFrame") -> dict[str, Any]:
    """A row of `tables.objects.LOCATED`."""
    from egad.measures.reeb import graph as reeb

    if not item.graph:
        return item.row
    near, distances = hood.nearest_to(reeb.unpack(item.graph))
    simpler = objects["complexity"] < item.row["complexity"]
    easier = objects["graspability"] > item.row["graspability"]
    return {
        **item.row,
        "complexity_percentile": 100 * simpler.mean(),
        "difficulty_percentile": 100 * easier.mean(),
        "diversity": float(distances.mean()) if len(distances) else 1.0,
        "nearest": objects["label"].iloc[near].tolist(),
        "distances": distances.tolist(),
    }


def _located(row: dict[str, Any], item: _Mine, among: "Dataset") -> "Located":
    from egad.report.locations import Located, Neighbor
    from egad.report.pictures import png_bytes, render

    neighbors = [
        Neighbor(label, distance, png_bytes(render(among[label].mesh, THUMBNAIL)))
        for label, distance in zip(row["nearest"], row["distances"], strict=True)
    ]
    return Located(row, item.picture, neighbors)
