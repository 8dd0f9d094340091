"""The position of meshes among the objects of a dataset, and their nearest objects."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli.common import (
    CORES,
    Config,
    Jobs,
    MaxCandidates,
    Meshes,
    Units,
    complain,
    files_in,
    out_option,
    reasons_in,
    settings_in,
    with_option,
)
from egad.cli.measure import SIZE, measure_row, sizes, warn_of_measures
from egad.config import Shape, Similarity
from egad.config.stages import LocateMeshes, select
from egad.errors import RejectedError, UserError

if TYPE_CHECKING:
    import pandas as pd
    import trimesh

    from egad.reeb import Neighborhood
    from egad.report.locations import Located

PORTRAIT, THUMBNAIL = 192, 96


def locate(
    meshes: Meshes,
    among: Annotated[
        Path, typer.Option("--in", help="archive.parquet, `released`, or folder of a dataset")
    ],
    units: Units = None,
    out: Annotated[
        list[Path], out_option("file to write: .html, .parquet or .csv; may be repeated")
    ] = [Path("locate.html")],  # noqa: B006 (typer copies it)
    max_candidates: MaxCandidates = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Show the positions of meshes in the space of a dataset, and the most similar objects."""
    from egad._util.files import write_text
    from egad.cli.terminal_tables import located
    from egad.data import archive_path
    from egad.io import check_ending, object_names, write_frame
    from egad.report.axes import axis_pair
    from egad.report.locations import page
    from egad.tables.objects import LOCATED

    for path in out:
        check_ending(path, (".html", ".parquet", ".csv"))
    option = ("--max-candidates", "postprocess.max_candidates", max_candidates)
    settings = select(with_option(settings_in(config), *option), LocateMeshes)
    objects = reference(archive_path(among), settings)
    files = object_names(files_in(meshes, units))
    table, shown = locate_files(settings, objects, files, units, jobs)
    reasons, axes = reasons_in(table), axis_pair(settings.measures)
    for path in out:
        if path.suffix.lower() == ".html":
            text = page(str(among), objects.objects, shown, reasons, settings.space, axes)
            write_text(path, text)
        else:
            write_frame(table, LOCATED, path)
    located(table, axes)
    complain(reasons, len(table))


@dataclass(frozen=True)
class Reference:
    """The objects that others are compared with.

    Attributes:
        objects: Columns label, complexity, graspability and cells.
        load: For each label, how to get the mesh.
    """

    objects: "pd.DataFrame"
    load: "Mapping[str, Callable[[], trimesh.Trimesh]]"


def reference(path: Path, settings: LocateMeshes) -> Reference:
    """The objects of an archive, or of a folder of a dataset.

    Args:
        path: An `archive.parquet`, an `objects.parquet` with `meshes/` beside it, or the folder
            of these.
        settings: Settings that the objects were made with.

    Raises:
        UserError: There is neither, or it was made with a different grid.
        TableError: The table is damaged.
    """
    from egad.config.archive_settings import check_provenance
    from egad.tables import parquet
    from egad.tables.evolution import ARCHIVE
    from egad.tables.objects import OBJECTS

    if path.is_dir():
        path = path / "objects.parquet"
    if not path.is_file():
        raise UserError(f"--in {path}: no such file; give an archive or the folder of a dataset")
    names = parquet.columns(path)
    if "voxels" in names:
        check_provenance(path, settings, ("shape",))
        found = _of_archive(parquet.read(path, ARCHIVE), settings.shape)
    elif "watertight" in names:
        found = _of_dataset(parquet.read(path, OBJECTS), path.parent / "meshes")
    else:
        raise UserError(f"--in {path}: neither an archive nor the objects of a dataset")
    cells = found.objects[["complexity_cell", "difficulty_cell"]].to_numpy()
    if len(cells) and cells.max() >= settings.space.cells:
        raise UserError(
            f"--in {path}: cells up to {cells.max()}, but the configuration has "
            f"{settings.space.cells} along each axis; name the one of that dataset with --config"
        )
    return found


def _of_dataset(objects: "pd.DataFrame", meshes: Path) -> Reference:
    from egad.io import read_mesh

    files = {label: meshes / f"{label}.obj" for label in objects["label"]}
    if missing := [file for file in files.values() if not file.is_file()]:
        raise UserError(f"{missing[0]}: this mesh of the dataset is missing")
    return Reference(
        objects, {label: partial(read_mesh, file, "m") for label, file in files.items()}
    )


def _of_archive(archive: "pd.DataFrame", shape: Shape) -> Reference:
    from egad.measures import labels

    ordered = archive.sort_values(["difficulty_cell", "complexity_cell", "slot"])
    names = labels(ordered["complexity_cell"], ordered["difficulty_cell"])
    solids = zip(names, ordered["voxels"], strict=True)
    return Reference(
        ordered.assign(label=names).reset_index(drop=True),
        {label: partial(_surface, packed, shape) for label, packed in solids},
    )


def _surface(packed: bytes, shape: Shape) -> "trimesh.Trimesh":
    """The mesh of voxels as files hold it, so that it is at distance 0 from its own file."""
    from egad.cppn import packed_surface
    from egad.geometry import in_single_precision

    return in_single_precision(packed_surface(packed, shape))


def locate_files(
    settings: LocateMeshes,
    among: Reference,
    files: Mapping[str, Path],
    units: str | None,
    worker_count: int,
) -> "tuple[pd.DataFrame, list[Located]]":
    """Locate meshes among the objects of a dataset.

    Args:
        settings: Settings of this tool.
        among: The objects of the dataset.
        files: Mesh files by name.
        units: Unit of their coordinates; None: as the files say.
        worker_count: Processes; the result does not depend on it.

    Returns:
        Columns of `tables.objects.LOCATED`, one row per mesh in the given order; and the contents
        of the page for the usable meshes.
    """
    import pandas as pd

    from egad.reeb import Neighborhood
    from egad.reeb import graph as reeb
    from egad.tables.objects import LOCATED, MEASURED
    from egad.workflow.mesh_files import warn_of_units

    similarity = settings.similarity
    with workers(worker_count) as mapper:
        work = partial(_mine, units=units, settings=settings)
        mine = list(progress(mapper(work, files.items()), "measuring", len(files)))
        graphs = mapper(partial(_graph, settings=similarity), among.load.values())
        packed = list(progress(graphs, "Reeb graphs", len(among.load)))
    hood = Neighborhood(similarity.weight, settings.space.neighbors)
    hood.add(reeb.unpack(graph) for graph in packed)  # indices are those of the rows
    rows = [_placed(item, hood, among.objects) for item in mine]
    warn_of_units(sizes(item.row for item in mine), units)
    warn_of_measures(pd.DataFrame([item.row for item in mine], columns=MEASURED.names))
    return pd.DataFrame(rows, columns=LOCATED.names), [
        _located(row, item, among) for row, item in zip(rows, mine, strict=True) if item.graph
    ]


class _Mine(NamedTuple):
    """A mesh of the user: its row, and its packed graph and picture if it could be used."""

    row: dict[str, Any]
    graph: bytes = b""
    picture: bytes = b""


def _mine(item: tuple[str, Path], units: str | None, settings: LocateMeshes) -> _Mine:
    from egad.io import read_mesh
    from egad.reeb import graph as reeb
    from egad.report.pictures import png_bytes, render

    name, path = item
    found: dict[str, Any] = {"name": name, "reason": ""}
    try:
        mesh = read_mesh(path, units)
        found[SIZE] = float(mesh.extents.max())
        solid, row = measure_row(mesh, settings)
        graph = reeb.pack(reeb.extract(solid, settings.similarity))
    except RejectedError as reason:
        return _Mine({**found, "reason": str(reason)})
    return _Mine({**found, **row}, graph, png_bytes(render(solid, PORTRAIT)))


def _graph(load: "Callable[[], trimesh.Trimesh]", settings: Similarity) -> bytes:
    from egad.reeb import graph as reeb

    return reeb.pack(reeb.extract(load(), settings))


def _placed(item: _Mine, hood: "Neighborhood", objects: "pd.DataFrame") -> dict[str, Any]:
    """A row of `tables.objects.LOCATED`."""
    from egad.reeb import graph as reeb

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


def _located(row: dict[str, Any], item: _Mine, among: Reference) -> "Located":
    from egad.report.locations import Located, Neighbor
    from egad.report.pictures import png_bytes, render

    neighbors = [
        Neighbor(label, distance, png_bytes(render(among.load[label](), THUMBNAIL)))
        for label, distance in zip(row["nearest"], row["distances"], strict=True)
    ]
    return Located(row, item.picture, neighbors)
