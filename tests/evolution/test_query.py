import math

import numpy as np
import pytest

from egad.evolution import Neat, genome
from egad.evolution import query as cppn
from egad.tables.evolution import GENOME

ACTIVATIONS = {
    "sin": math.sin,
    "sigmoid": lambda x: 1 / (1 + math.exp(-5 * x)),
    "gaussian": lambda x: math.exp(-5 * x * x),
    "identity": lambda x: x,
}


def slow_query(row, x, y, z):
    """One point at a time, by recursion."""
    radii = math.hypot(x, y), math.hypot(x, z), math.hypot(y, z), math.hypot(x, y, z)
    inputs = dict(zip(range(-1, -8, -1), (x, y, z, *radii), strict=True))
    links = list(
        zip(
            row["connection_sources"],
            row["connection_targets"],
            row["connection_weights"],
            row["connection_enabled"],
            strict=True,
        )
    )

    def value(node):
        if node in inputs:
            return inputs[node]
        place = row["node_keys"].index(node)
        total = row["node_biases"][place]
        total += sum(w * value(s) for s, t, w, enabled in links if enabled and t == node)
        return ACTIVATIONS[row["node_activations"][place]](total)

    return value(0)


@pytest.mark.parametrize("seed", range(5))
def test_equals_the_query_of_one_point_at_a_time(seed):
    settings = Neat(node_addition_rate=0.4, connection_addition_rate=0.6, weight_limit=2)
    config = genome.neat_config(settings)
    row = genome.random_genome(config, seed)
    for generation in range(15):
        row = genome.child(config, [row], generation)
    assert len(row["node_keys"]) > 1
    field = cppn.query(row, 5)
    line = np.linspace(-1, 1, 5)
    for i, j, k in np.random.default_rng(0).integers(5, size=(20, 3)):
        expected = slow_query(row, line[i], line[j], line[k])
        assert field[i, j, k] == pytest.approx(expected, abs=2e-3)


def test_a_genome_without_connections_is_constant():
    row = {name: [] for name in GENOME.names}
    row |= {"node_keys": [0], "node_biases": [0.7], "node_activations": ["identity"]}
    assert np.all(cppn.query(row, 4) == np.float32(0.7))


def test_an_overflowing_network_gives_no_error():
    row = {
        "node_keys": [0, 1],
        "node_biases": [0.0, 3e38],
        "node_activations": ["sin", "identity"],
        "connection_sources": [1],
        "connection_targets": [0],
        "connection_weights": [30.0],
        "connection_enabled": [True],
    }
    assert np.isnan(cppn.query(row, 3)).all()


def test_unknown_activation_is_named():
    with pytest.raises(ValueError, match="softplus"):
        cppn.activate("softplus", np.zeros(1, np.float32))
