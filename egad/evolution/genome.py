"""CPPN genomes: random, mutated and crossed ones (NEAT), and their table rows.

neat-python does the breeding. Node keys and innovation numbers are hashes of what they name, so a
gene means the same on every island without communication between them.
"""

import hashlib
import random
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import neat
from neat.genome import DefaultGenomeConfig

from egad.evolution.parameters import Neat

INPUTS = ("x", "y", "z", "xy", "xz", "yz", "xyz")
OUTPUT = 0
Row = Mapping[str, Any]


def _stable_hash(*parts: int) -> int:
    """A positive 62-bit number that two islands agree on."""
    text = ",".join(map(str, parts)).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "little") >> 2


class _NamedInnovations:
    """Gives a connection the innovation number that follows from its two nodes."""

    def get_innovation_number(self, source: int, target: int, _mutation: str = "") -> int:
        return _stable_hash(source, target)


class Genome(neat.DefaultGenome):  # type: ignore[misc]
    """A NEAT genome whose new nodes are named after the connection that they split."""

    def mutate_add_node(self, config: DefaultGenomeConfig) -> None:
        """Split a random connection by a node with zero bias (NEAT, section 3.1)."""
        if not self.connections:
            return
        split = random.choice(list(self.connections.values()))  # noqa: S311 (not for secrets)
        source, target = split.key
        key = _stable_hash(source, target, -1)
        while key in self.nodes:
            key = _stable_hash(source, target, key)
        node = self.create_node(config, key)
        node.bias = 0.0
        self.nodes[key] = node
        split.enabled = False
        self.add_connection(config, source, key, 1.0, True)
        self.add_connection(config, key, target, split.weight, True)


def neat_config(settings: Neat) -> DefaultGenomeConfig:
    """neat-python's configuration for the settings of a genome."""
    values: dict[str, Any] = {
        "num_inputs": len(INPUTS),
        "num_outputs": 1,
        "num_hidden": 0,
        "feed_forward": "true",
        "initial_connection": f"partial_direct {settings.initial_connections}",
        "compatibility_disjoint_coefficient": 1.0,
        "compatibility_weight_coefficient": 1.0,
        "conn_add_prob": settings.connection_addition_rate,
        "conn_delete_prob": settings.connection_deletion_rate,
        "node_add_prob": settings.node_addition_rate,
        "node_delete_prob": settings.node_deletion_rate,
        "activation_default": "random",
        "activation_options": " ".join(settings.activations),
        "activation_mutate_rate": settings.activation_mutation_rate,
        "aggregation_default": "sum",
        "aggregation_options": "sum",
        "aggregation_mutate_rate": 0.0,
        "enabled_default": "true",
        "enabled_mutate_rate": settings.connection_toggle_rate,
        **_float_attribute("response", settings, mean=1.0),
        **_float_attribute("bias", settings),
        **_float_attribute("weight", settings),
    }
    config = Genome.parse_config(values)
    config.innovation_tracker = _NamedInnovations()
    return config


def _float_attribute(name: str, settings: Neat, mean: float = 0.0) -> dict[str, float]:
    """The settings of a number of a gene; those that `Neat` does not have are 0."""
    return {
        f"{name}_init_mean": mean,
        f"{name}_init_stdev": getattr(settings, f"{name}_sigma", 0.0),
        f"{name}_mutate_rate": getattr(settings, f"{name}_mutation_rate", 0.0),
        f"{name}_mutate_power": getattr(settings, f"{name}_mutation_sigma", 0.0),
        f"{name}_replace_rate": getattr(settings, f"{name}_replacement_rate", 0.0),
        f"{name}_min_value": -settings.weight_limit,
        f"{name}_max_value": settings.weight_limit,
    }


def random_genome(config: DefaultGenomeConfig, seed: int) -> Row:
    """The row of a new genome: no hidden nodes, some inputs connected to the output."""
    with _seeded(seed):
        genome = Genome(0)
        genome.configure_new(config)
    return to_row(genome)


def child(config: DefaultGenomeConfig, parents: Sequence[Row], seed: int) -> Row:
    """The row of a mutated child; genes that only one of two parents has are of the first."""
    with _seeded(seed):
        genome = from_row(config, parents[0])
        if len(parents) > 1:
            first, second = genome, from_row(config, parents[1])
            first.fitness, second.fitness = 1.0, 0.0
            genome = Genome(0)
            genome.configure_crossover(first, second, config)
        genome.mutate(config)
    return to_row(genome)


@contextmanager
def _seeded(seed: int) -> Iterator[None]:
    """neat-python draws from the global generator: seed it, and restore its state afterwards."""
    state = random.getstate()
    random.seed(seed)
    try:
        yield
    finally:
        random.setstate(state)


def to_row(genome: Genome) -> Row:
    """The columns of `tables.evolution.GENOME`, genes sorted by key."""
    nodes = [genome.nodes[key] for key in sorted(genome.nodes)]
    connections = [genome.connections[key] for key in sorted(genome.connections)]
    return {
        "node_keys": [node.key for node in nodes],
        "node_biases": [node.bias for node in nodes],
        "node_activations": [node.activation for node in nodes],
        "connection_sources": [gene.key[0] for gene in connections],
        "connection_targets": [gene.key[1] for gene in connections],
        "connection_weights": [gene.weight for gene in connections],
        "connection_enabled": [gene.enabled for gene in connections],
    }


def from_row(config: DefaultGenomeConfig, row: Row) -> Genome:
    """The genome of a table row."""
    genome = Genome(0)
    for key, bias, activation in zip(
        row["node_keys"], row["node_biases"], row["node_activations"], strict=True
    ):
        node = genome.create_node(config, int(key))
        node.bias, node.activation = float(bias), str(activation)
        genome.nodes[int(key)] = node
    for source, target, weight, enabled in connections(row):
        genome.add_connection(config, source, target, weight, enabled)
    return genome


def connections(row: Row) -> Iterator[tuple[int, int, float, bool]]:
    """Source, target, weight and whether it is in use, of each connection of a table row."""
    for source, target, weight, enabled in zip(
        row["connection_sources"],
        row["connection_targets"],
        row["connection_weights"],
        row["connection_enabled"],
        strict=True,
    ):
        yield int(source), int(target), float(weight), bool(enabled)
