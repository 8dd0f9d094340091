"""Tables of evolution: genomes, archives, and the steps of a run."""

import pyarrow as pa

from egad.tables.columns import (
    BINARY,
    BOOL,
    CELL_CONFIDENCE,
    CELLS,
    COMPLEXITY,
    DIVERSITY,
    FLOAT,
    GRASPABILITY,
    GRASPABILITY_STD,
    ID,
    INT,
    STRING,
    Result,
    column,
    optional,
)

GENOME = pa.schema(
    [
        column("node_keys", pa.list_(pa.int64()), "nodes; 0 is the output, -1..-7 are inputs"),
        column("node_biases", pa.list_(FLOAT), "bias of each node"),
        column("node_activations", pa.list_(STRING), "activation function of each node"),
        column("connection_sources", pa.list_(pa.int64()), "node that each connection leaves"),
        column("connection_targets", pa.list_(pa.int64()), "node that each connection enters"),
        column("connection_weights", pa.list_(FLOAT), "weight of each connection"),
        column("connection_enabled", pa.list_(BOOL), "whether each connection is in use"),
    ]
)

_ORIGIN = [
    column("parents", pa.list_(STRING), "ids of the parents; empty for a random genome"),
    column("epoch", INT, "epoch in which the object was created"),
]
_ERRORS = [
    optional(GRASPABILITY_STD),
    optional(CELL_CONFIDENCE),
]  # archives of other programs may have none
ARCHIVE = pa.schema(
    [
        ID,
        *GENOME,
        column("voxels", BINARY, "solid voxels, x slowest and z fastest, one bit each"),
        COMPLEXITY,
        GRASPABILITY,
        *_ERRORS,
        DIVERSITY,
        *CELLS,
        column("slot", INT, "slot of the object in its cell, 0 = most diverse"),
        *_ORIGIN,
    ]
)

EPOCH = pa.schema([*ARCHIVE, column("graph", BINARY, "packed Reeb graph of the object")])

LINEAGE = pa.schema(
    [
        ID,
        *GENOME,
        COMPLEXITY,
        GRASPABILITY,
        *_ERRORS,
        *_ORIGIN,
        column("island", INT, "island on which the object was created"),
        column("step", INT, "step of the epoch in which the object was created"),
    ]
)

HISTORY = pa.schema(
    [
        column("epoch", INT, "number of the epoch"),
        column("island", INT, "number of the island"),
        column("step", INT, "number of the step in its epoch"),
        column("offspring", INT, "number of offspring of this step"),
        column("evaluated", INT, "number of offspring measured and offered to the archive"),
        column(
            "refined", INT, "number of offspring measured again because the archive would keep them"
        ),
        column("empty", INT, "number of offspring without any solid voxel"),
        column("known", INT, "number of offspring with the same voxels as another object"),
        column("elites", INT, "number of objects in the archive of the island after the step"),
        column("coverage", FLOAT, "archive coverage: fraction of the slots that are filled"),
        column("filled_cells", FLOAT, "fraction of the cells that hold at least one object"),
        column("qd_score", FLOAT, "sum of the diversities; computed every tenth step"),
        column(
            "cells", BINARY, "number of objects in each cell, one byte each, by rows of difficulty"
        ),
    ]
)

FILES = [
    Result("D/archive.parquet", "elites of evolution", ARCHIVE),
    Result("D/history.parquet", "statistics of the archive after each step", HISTORY),
    Result("D/ancestry.parquet", "elites and all their ancestors", LINEAGE),
]
