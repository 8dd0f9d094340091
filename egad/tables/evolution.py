"""Tables of evolution: genomes, archives, and the steps of a run."""

import pyarrow as pa

from egad.tables.columns import (
    BOOL,
    CELL_CONFIDENCE,
    CELLS,
    COMPLEXITY,
    DIVERSITY,
    FLOAT,
    GRASPABILITY,
    GRASPABILITY_STD,
    ID,
    STRING,
    Result,
    binary,
    integer,
    optional,
    real,
    schema,
    values,
)

GENOME = schema(
    values("node_keys", "nodes; 0 is the output, -1..-7 are inputs", of=pa.int64()),
    values("node_biases", "bias of each node", of=FLOAT),
    values("node_activations", "activation function of each node", of=STRING),
    values("connection_sources", "node that each connection leaves", of=pa.int64()),
    values("connection_targets", "node that each connection enters", of=pa.int64()),
    values("connection_weights", "weight of each connection", of=FLOAT),
    values("connection_enabled", "whether each connection is in use", of=BOOL),
)

_ORIGIN = [
    values("parents", "ids of the parents; empty for a random genome", of=STRING),
    integer("epoch", "epoch in which the object was created"),
]
_ERRORS = [
    optional(GRASPABILITY_STD),
    optional(CELL_CONFIDENCE),
]  # archives of other programs may have none
ARCHIVE = schema(
    ID,
    *GENOME,
    binary("voxels", "solid voxels, x slowest and z fastest, one bit each"),
    COMPLEXITY,
    GRASPABILITY,
    *_ERRORS,
    DIVERSITY,
    *CELLS,
    integer("slot", "slot of the object in its cell, 0 = most diverse"),
    *_ORIGIN,
)

EPOCH = schema(*ARCHIVE, binary("graph", "packed Reeb graph of the object"))

LINEAGE = schema(
    ID,
    *GENOME,
    COMPLEXITY,
    GRASPABILITY,
    *_ERRORS,
    *_ORIGIN,
    integer("island", "island on which the object was created"),
    integer("step", "step of the epoch in which the object was created"),
)

HISTORY = schema(
    integer("epoch", "number of the epoch"),
    integer("island", "number of the island"),
    integer("step", "number of the step in its epoch"),
    integer("offspring", "number of offspring of this step"),
    integer("evaluated", "number of offspring measured and offered to the archive"),
    integer("refined", "number of offspring measured again because the archive would keep them"),
    integer("empty", "number of offspring without any solid voxel"),
    integer("known", "number of offspring with the same voxels as another object"),
    integer("elites", "number of objects in the archive of the island after the step"),
    real("coverage", "archive coverage: fraction of the slots that are filled"),
    real("filled_cells", "fraction of the cells that hold at least one object"),
    real("qd_score", "sum of the diversities; computed every tenth step"),
    binary("cells", "number of objects in each cell, one byte each, by rows of difficulty"),
)

FILES = [
    Result("D/archive.parquet", "elites of evolution", ARCHIVE),
    Result("D/history.parquet", "statistics of the archive after each step", HISTORY),
    Result("D/ancestry.parquet", "elites and all their ancestors", LINEAGE),
]
