"""Genomes as text: the text is Python, which gives what the network gives."""

import numpy as np
import pytest
from scipy.special import expit

import egad
from egad.evolution import Envelope, Hole, Neat, Shape, Symmetry, genome_text, used_nodes
from egad.evolution.expressions import EXACT, enough_digits
from egad.evolution.genome import child, neat_config, random_genome
from egad.evolution.query import query

NUMPY = {name: getattr(np, name) for name in ("sqrt", "exp", "sin", "cos", "abs", "arctan2")}
FUNCTIONS = {
    "sigmoid": lambda a: expit(5 * a),
    "gaussian": lambda a: np.exp(-5 * a**2),
    "identity": lambda a: a,
}
SIDE = 13


def run(text, side=SIDE):
    """All variables of a text at the points of a grid."""
    line = np.linspace(-1, 1, side)
    grid = dict(zip("xyz", np.meshgrid(line, line, line, indexing="ij"), strict=True))
    variables = {**NUMPY, **FUNCTIONS, **grid}
    exec(text, variables)  # noqa: S102 (text that egad has made)
    return variables


@pytest.fixture(scope="module")
def grown():
    """Genomes with many hidden nodes and connections."""
    settings = Neat(node_addition_rate=0.5, connection_addition_rate=0.7, weight_limit=2)
    config, rows = neat_config(settings), []
    for seed in range(6):
        row = random_genome(config, seed)
        for generation in range(18):
            row = child(config, [row], generation)
        rows.append(row)
    return rows


@pytest.fixture(scope="module")
def released():
    return egad.load("released")


def check(text, genome, symmetry=None):
    expected = query(genome, SIDE, symmetry or Symmetry())
    found = run(text)
    assert np.broadcast_to(found["output"], expected.shape) == pytest.approx(expected, abs=2e-3)
    clear = np.abs(expected - 0.5) > 2e-3
    assert np.array_equal((found["solid"] & clear), (expected > 0.5) & clear)


def test_exact_text_gives_the_output_of_the_network(grown, released):
    for genome in [*grown, *(each.genome for each in list(released)[::150])]:
        check(genome_text(genome, digits=EXACT), genome)


def test_few_digits_change_no_voxel_and_fewer_would(released):
    shape = Shape()
    for each in list(released)[::300]:
        digits = enough_digits(each.genome, shape)
        solids = {}
        for count in (digits - 1, digits):
            text = genome_text(each.genome, digits=count)
            solids[count] = run(text, shape.resolution)["solid"]
        expected = query(each.genome, shape.resolution) > shape.threshold
        assert np.mean(solids[digits] != expected) < 1e-3  # doubles differ in the last bit
        assert digits == 2 or not np.array_equal(solids[digits - 1], expected)
        assert genome_text(each.genome) == genome_text(each.genome, digits=digits)


@pytest.mark.parametrize(
    "symmetry",
    [
        Symmetry(mirror=("x", "z")),
        Symmetry(axis="y", fold=3),
        Symmetry(axis="z", fold=3, mirror=("x",)),
        Symmetry(axis="z", fold=4, mirror=("x", "y")),
    ],
)
def test_symmetry_is_in_the_text(grown, symmetry):
    for genome in grown[:3]:
        check(genome_text(genome, digits=EXACT, symmetry=symmetry), genome, symmetry)


def test_what_the_output_does_not_depend_on_is_left_out():
    genome = {
        "node_keys": [0, 5, 9],
        "node_biases": [-0.25, 1.0, 2.0],
        "node_activations": ["identity", "sin", "gaussian"],
        "connection_sources": [-1, 5, -2, 9],
        "connection_targets": [5, 0, 9, 0],
        "connection_weights": [2.0, -3.0, 4.0, 5.0],
        "connection_enabled": [True, True, True, False],
    }
    assert [node.name for node in used_nodes(genome)] == ["h1", "output"]
    assert genome_text(genome, digits=3).splitlines() == [
        "# x, y, z run from -1 to 1 over the cube.",
        "# identity(a) = a",
        "h1 = sin(2*x + 1)",
        "output = identity(-3*h1 - 0.25)",
        "solid = output > 0.5",
        "# Then hidden holes are filled, thin parts are removed, and the largest body is kept.",
    ]
    cut = {**genome, "connection_enabled": [False] * 4}
    assert "output = identity(-0.25)" in genome_text(cut)


def test_regions_and_threshold_are_named(grown):
    regions = {"envelope": Envelope(kind="box", size=(1, 1, 0.5)), "hole": Hole()}
    text = genome_text(grown[0], shape=Shape(threshold=0.25), regions=regions)
    assert "solid = output > 0.25" in text
    assert "# envelope: box, sides (1, 1, 0.5) of the cube" in text
    assert "hole:" not in text
