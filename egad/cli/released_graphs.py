"""Reeb graphs of datasets; those of the released objects are shipped.

`python -m egad.cli.released_graphs` makes the file that is shipped, in some minutes.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import Mapper, workers
from egad.data import released_graphs
from egad.evolution import Shape
from egad.measures.reeb import Similarity
from egad.measures.reeb import graph as reeb
from egad.objects import Dataset, NamedMesh, load, named_meshes
from egad.tables import parquet
from egad.tables.objects import GRAPHS


def dataset_graphs(
    objects: Dataset, settings: Similarity, mapper: Mapper, shipped: bool = True
) -> list[bytes]:
    """Packed Reeb graphs of a dataset, in its order; those shipped have single precision."""
    known: dict[str, bytes] = {}
    if shipped and (settings, objects.shape) == (Similarity(), Shape()):
        table = parquet.read(released_graphs(), GRAPHS)
        known = dict(zip(table["id"], table["graph"], strict=True))
    missing = [
        label for name, label in objects.table[["id", "label"]].to_numpy() if name not in known
    ]
    if missing:
        graphs = mapper(partial(_graph, settings=settings), named_meshes(objects.select(missing)))
        packed = list(progress(graphs, "Reeb graphs", len(missing)))
        known |= dict(zip(objects.select(missing).table["id"], packed, strict=True))
    return [known[name] for name in objects.table["id"]]


def _graph(item: NamedMesh, settings: Similarity) -> bytes:
    return reeb.pack(reeb.extract(item.mesh(), settings))


def in_single_precision(packed: bytes) -> bytes:
    """A packed graph whose numbers are rounded, so that it compresses well."""
    graph = reeb.unpack(packed)
    areas, lengths = (
        each.astype(np.float32).astype(float) for each in (graph.areas, graph.lengths)
    )
    return reeb.pack(replace(graph, areas=areas, lengths=lengths))


def main() -> None:
    """Make the file that is shipped."""
    objects = load()
    with workers(2) as mapper:
        packed = dataset_graphs(objects, Similarity(), mapper, shipped=False)
    table = pd.DataFrame({"id": objects.table["id"], "graph": map(in_single_precision, packed)})
    parquet.write(table, GRAPHS, released_graphs())


if __name__ == "__main__":
    main()
