"""locate: where any meshes lie among the objects of a dataset, and what is most like them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad import tables
from egad.errors import RejectedError, UserError
from egad.exchange.meshes import read_mesh
from egad.measures import reeb
from egad.measures.neighbours import Neighbourhood
from egad.measures.space import labels
from egad.progress import progress
from egad.report.locations import Located, Neighbour
from egad.report.render import png_bytes, render
from egad.settings import Shape, Similarity
from egad.shapes.surface import packed_surface
from egad.stage_settings import LocateMeshes
from egad.stages.measure import measured, warn_of_units
from egad.workers import workers

PORTRAIT, THUMBNAIL = 192, 96


@dataclass(frozen=True)
class Reference:
    """The objects that others are compared with.

    Attributes:
        objects: Columns label, complexity, difficulty and cells.
        load: For each label, how to get the mesh.
    """

    objects: pd.DataFrame
    load: Mapping[str, Callable[[], trimesh.Trimesh]]


def reference(path: Path, shape: Shape) -> Reference:
    """The objects of an archive, or of a folder of a dataset.

    Args:
        path: An `archive.parquet`, an `objects.parquet` with `meshes/` beside it, or the folder
            of these.
        shape: The settings that an archive was evolved with.

    Raises:
        UserError: There is neither.
        TableError: The table is damaged.
    """
    if path.is_dir():
        path = path / "objects.parquet"
    if not path.is_file():
        raise UserError(f"--in {path}: no such file; name an archive or the folder of a dataset")
    try:
        objects = tables.read(path, tables.OBJECTS)
    except tables.TableError:
        archive = tables.read(path, tables.ARCHIVE)
        return _of_archive(archive, shape)
    meshes = path.parent / "meshes"
    return Reference(
        objects,
        {label: partial(read_mesh, meshes / f"{label}.obj", "m") for label in objects["label"]},
    )


def _of_archive(archive: pd.DataFrame, shape: Shape) -> Reference:
    ordered = archive.sort_values(["difficulty_cell", "complexity_cell", "slot"])
    names = labels(ordered["complexity_cell"], ordered["difficulty_cell"])

    solids = zip(names, ordered["voxels"], strict=True)
    return Reference(
        ordered.assign(label=names).reset_index(drop=True),
        {label: partial(packed_surface, packed, shape) for label, packed in solids},
    )


def run(
    settings: LocateMeshes,
    among: Reference,
    files: Mapping[str, Path],
    units: str,
    worker_count: int,
) -> tuple[pd.DataFrame, list[Located]]:
    """Place meshes among the objects of a dataset.

    Args:
        settings: What this tool reads.
        among: The objects of the dataset.
        files: Mesh files by name.
        units: Unit of their coordinates.
        worker_count: Processes; the result does not depend on it.

    Returns:
        Columns of `egad.tables.LOCATED`, a row a mesh in the order given; and what a page shows
        of those that could be used.
    """
    similarity = settings.similarity
    with workers(worker_count) as mapper:
        work = partial(_mine, units=units, settings=settings)
        mine = list(progress(mapper(work, files.items()), "measuring", len(files)))
        graphs = mapper(partial(_graph, settings=similarity), among.load.values())
        packed = list(progress(graphs, "Reeb graphs", len(among.load)))
    near = _Nearest(settings, among.objects, [reeb.unpack(graph) for graph in packed])
    rows = [_placed(item, near, among.objects) for item in mine]
    warn_of_units(pd.DataFrame([item.row for item in mine], columns=tables.MEASURED.names), units)
    return pd.DataFrame(rows, columns=tables.LOCATED.names), [
        _located(row, item, among) for row, item in zip(rows, mine, strict=True) if item.graph
    ]


class _Mine(NamedTuple):
    """A mesh of the user: its row, and its packed graph and picture if it could be used."""

    row: dict[str, Any]
    graph: bytes = b""
    picture: bytes = b""


def _mine(item: tuple[str, Path], units: str, settings: LocateMeshes) -> _Mine:
    name, path = item
    try:
        solid, row = measured(name, read_mesh(path, units), settings)
        graph = reeb.pack(reeb.extract(solid, settings.similarity))
    except RejectedError as reason:
        return _Mine({"name": name, "reason": str(reason)})
    return _Mine({"name": name, **row, "reason": ""}, graph, png_bytes(render(solid, PORTRAIT)))


def _graph(load: Callable[[], trimesh.Trimesh], settings: Similarity) -> bytes:
    return reeb.pack(reeb.extract(load(), settings))


class _Nearest:
    """The nearest objects of a dataset to shapes that do not belong to it."""

    def __init__(
        self, settings: LocateMeshes, objects: pd.DataFrame, graphs: list[reeb.ReebGraph]
    ) -> None:
        self._hood = Neighbourhood(settings.similarity.weight, settings.space.neighbours)
        indices = self._hood.add(graphs)
        self._names = dict(zip(indices, objects["label"], strict=True))

    def __call__(self, packed: bytes) -> tuple[list[str], list[float]]:
        (index,) = self._hood.add([reeb.unpack(packed)])
        near, distances = self._hood.nearest(index)
        self._hood.remove(index)
        return [self._names[each] for each in near], distances.tolist()


def _placed(item: _Mine, near: _Nearest, objects: pd.DataFrame) -> dict[str, Any]:
    """A row of `egad.tables.LOCATED`."""
    if not item.graph:
        return item.row
    names, distances = near(item.graph)
    return {
        **item.row,
        "complexity_percentile": 100 * (objects["complexity"] < item.row["complexity"]).mean(),
        "difficulty_percentile": 100 * (objects["difficulty"] > item.row["difficulty"]).mean(),
        "diversity": float(np.mean(distances)) if distances else 1.0,
        "nearest": names,
        "distances": distances,
    }


def _located(row: dict[str, Any], item: _Mine, among: Reference) -> Located:
    neighbours = [
        Neighbour(label, distance, png_bytes(render(among.load[label](), THUMBNAIL)))
        for label, distance in zip(row["nearest"], row["distances"], strict=True)
    ]
    return Located(row, item.picture, neighbours)
