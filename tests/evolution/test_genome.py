import random
import subprocess
import sys

import pytest

from egad.evolution import Neat, genome


def grown(config, seed, generations=30):
    """A genome that has mutated often enough to have hidden nodes."""
    row = genome.random_genome(config, seed)
    for generation in range(generations):
        row = genome.child(config, [row], 1000 * seed + generation)
    return row


@pytest.fixture(scope="module")
def config():
    return genome.neat_config(Neat(node_addition_rate=0.5, connection_addition_rate=0.5))


def test_row_round_trip(config):
    row = grown(config, 1)
    assert len(row["node_keys"]) > 2
    assert genome.to_row(genome.from_row(config, row)) == row


def test_same_seed_same_child_and_another_seed_another_child(config):
    parent = grown(config, 1)
    assert genome.child(config, [parent], 5) == genome.child(config, [parent], 5)
    assert genome.child(config, [parent], 5) != genome.child(config, [parent], 6)


def test_the_global_generator_is_left_as_it_was(config):
    state = random.getstate()
    grown(config, 1, generations=3)
    assert random.getstate() == state


def test_children_do_not_depend_on_hash_randomisation():
    code = (
        "from egad.evolution.parameters import Neat; from egad.evolution import genome\n"
        "c = genome.neat_config(Neat(node_addition_rate=0.5))\n"
        "a, b = genome.random_genome(c, 1), genome.random_genome(c, 2)\n"
        "for i in range(30): a, b = genome.child(c, [a, b], i), genome.child(c, [b, a], 99 + i)\n"
        "print(a)"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert len(outputs.pop()) > 100


def test_two_islands_give_the_same_split_the_same_name():
    start = genome.random_genome(genome.neat_config(Neat()), 4)
    names = set()
    for seed in range(2):  # two islands: fresh configurations that never met
        config = genome.neat_config(Neat(node_addition_rate=1.0, node_deletion_rate=0.0))
        individual = genome.from_row(config, start)
        random.seed(seed)
        individual.mutate_add_node(config)
        names.add(tuple(sorted(individual.nodes)))
    assert len(names) == 1


def test_crossing_genomes_of_different_islands_lines_up_their_genes(config):
    ancestor = grown(config, 7)
    one, two = ancestor, ancestor
    for generation in range(10):
        one = genome.child(config, [one], 100 + generation)
        two = genome.child(config, [two], 200 + generation)
    still = genome.neat_config(
        Neat(**dict.fromkeys([name for name in Neat.model_fields if name.endswith("_rate")], 0.0))
    )
    cross = genome.child(still, [one, two], 1)
    links = [
        set(zip(row["connection_sources"], row["connection_targets"], strict=True))
        for row in (one, two, cross)
    ]
    shared = links[0] & links[1]
    assert shared
    assert links[2] <= links[0]  # genes of only one parent come from the first
    assert len(links[2]) >= len(shared)
