"""Compositional pattern-producing networks, queried at all points of a grid at once."""

from collections.abc import Mapping
from functools import lru_cache
from graphlib import TopologicalSorter
from typing import Any

import numpy as np
from scipy.special import expit

from egad._util.arrays import Singles
from egad.evolution.constraints import folded
from egad.evolution.genome import INPUTS, OUTPUT, connections
from egad.evolution.parameters import Symmetry

Field = Singles
NO_SYMMETRY = Symmetry()


@lru_cache(maxsize=4)
def grid_inputs(resolution: int, symmetry: Symmetry = NO_SYMMETRY) -> Field:
    """The inputs at all grid points, (7, resolution^3), in C order (EGAD, Table II)."""
    line = np.linspace(-1, 1, resolution, dtype=np.float32)
    x, y, z = (axis.ravel() for axis in np.meshgrid(line, line, line, indexing="ij"))
    if symmetry != NO_SYMMETRY:
        x, y, z = folded(np.stack([x, y, z]), symmetry)
    xx, yy, zz = x * x, y * y, z * z
    inputs = np.stack(
        [x, y, z, np.sqrt(xx + yy), np.sqrt(xx + zz), np.sqrt(yy + zz), np.sqrt(xx + yy + zz)]
    )
    inputs.flags.writeable = False
    return inputs


def query(row: Mapping[str, Any], resolution: int, symmetry: Symmetry = NO_SYMMETRY) -> Field:
    """The output of the network of a genome row at all grid points, (r, r, r); NaN: overflow."""
    inputs = grid_inputs(resolution, symmetry)
    values: dict[int, Field] = {-1 - index: inputs[index] for index in range(len(INPUTS))}
    biases = dict(zip(row["node_keys"], row["node_biases"], strict=True))
    activations = dict(zip(row["node_keys"], row["node_activations"], strict=True))
    with np.errstate(over="ignore", invalid="ignore"):
        for node, links in evaluation_order(row):
            total = np.full(inputs.shape[1], biases[node], dtype=np.float32)
            for source, weight in links:
                total += np.float32(weight) * values[source]
            values[node] = activate(activations[node], total)
    return values[OUTPUT].reshape((resolution,) * 3)


def evaluation_order(row: Mapping[str, Any]) -> list[tuple[int, list[tuple[int, float]]]]:
    """Keys of the nodes that the output depends on, in order, each with its inputs and weights."""
    incoming = _used_connections(row)
    order = TopologicalSorter({node: [s for s, _ in links] for node, links in incoming.items()})
    return [(node, incoming[node]) for node in order.static_order() if node >= 0]


def _used_connections(row: Mapping[str, Any]) -> dict[int, list[tuple[int, float]]]:
    """For each node that the output depends on: its enabled inputs and their weights."""
    incoming: dict[int, list[tuple[int, float]]] = {int(key): [] for key in row["node_keys"]}
    for source, target, weight, enabled in connections(row):
        if enabled:
            incoming[target].append((source, weight))
    used: dict[int, list[tuple[int, float]]] = {}
    waiting = [OUTPUT]
    while waiting:
        node = waiting.pop()
        if node >= 0 and node not in used:
            used[node] = incoming[node]
            waiting.extend(source for source, _ in incoming[node])
    return used


def activate(name: str, x: Field) -> Field:
    """An activation function, with the gains of the released EGAD code."""
    if name == "sin":
        return np.asarray(np.sin(x))
    if name == "sigmoid":
        return np.asarray(expit(5 * x), dtype=np.float32)
    if name == "gaussian":
        return np.asarray(np.exp(-5 * x * x))
    if name == "identity":
        return x
    raise ValueError(f"unknown activation {name!r}")
