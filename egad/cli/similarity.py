"""Pairwise similarity of meshes."""

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli import common
from egad.errors import RejectedError
from egad.measures.reeb import Bases, Similarity

if TYPE_CHECKING:
    import pandas as pd
    import trimesh

    from egad.measures.reeb.graph import ReebGraph


def similarity(
    meshes: common.Meshes,
    units: common.Units = None,
    out: common.TableFile = None,
    bases: Annotated[
        Bases | None,
        typer.Option(help="scan: as in the original program; default: as in the configuration"),
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Compute pairwise similarities of meshes: 1 for equal shapes, 0 for nothing in common."""
    from egad.cli.table_files import write_matrix
    from egad.cli.terminal_tables import square
    from egad.io import check_ending, object_names

    check_ending(out)
    whole = common.settings_in(config, {"--bases": ("similarity.bases", bases)})
    files = object_names(common.files_in(meshes, units))
    matrix, reasons = similarity_of_files(whole.similarity, files, units, jobs)
    if out is not None:
        write_matrix(matrix, out)
    square(matrix)
    common.complain(reasons, len(files))


def similarity_of_files(
    settings: Similarity, files: Mapping[str, Path], units: str | None, worker_count: int
) -> "tuple[pd.DataFrame, dict[str, str]]":
    """Similarities of mesh files by name, missing for rejected ones; and the reasons."""
    import pandas as pd

    from egad.io import warn_of_units
    from egad.measures.reeb import graph as reeb
    from egad.measures.reeb import similarity_matrix

    work = partial(_graph, units=units, settings=settings)
    with workers(min(worker_count, len(files))) as mapper:
        found = list(progress(mapper(work, files.values()), "Reeb graphs", len(files)))
    results = {name: result for name, (result, _) in zip(files, found, strict=True)}
    warn_of_units({name: side for name, (_, side) in zip(files, found, strict=True)}, units)
    reasons = {name: result for name, result in results.items() if isinstance(result, str)}
    graphs = {name: result for name, result in results.items() if isinstance(result, bytes)}
    names = pd.Index(list(files), name="name")
    watch = partial(progress, what="comparing", total=len(graphs))
    unpacked = [reeb.unpack(graph) for graph in graphs.values()]
    matrix = similarity_matrix(unpacked, settings.weight, worker_count, watch)
    used = list(graphs)
    return pd.DataFrame(matrix, used, used).reindex(index=names, columns=list(names)), reasons


def _graph(path: Path, units: str | None, settings: Similarity) -> tuple[bytes | str, float]:
    """The packed Reeb graph of a mesh, or the reason why there is none; and its longest side."""
    from egad.io import use_mesh
    from egad.measures.reeb import graph as reeb

    return use_mesh(path, units, lambda mesh: reeb.pack(graph_of(mesh, settings, path.stem)))


def graph_of(mesh: "trimesh.Trimesh", settings: Similarity, name: str) -> "ReebGraph":
    """The Reeb graph of a repaired mesh; with `scan` bases before it, if it has one there."""
    from egad.geometry.repair import repaired_mesh
    from egad.measures.reeb import graph as reeb

    if settings.bases == "scan":
        with suppress(RejectedError):
            return reeb.extract(mesh, settings)
    return reeb.extract(repaired_mesh(mesh, name), settings)
