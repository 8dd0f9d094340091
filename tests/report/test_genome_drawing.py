"""Drawings of genomes: everything that counts is drawn, once."""

import xml.etree.ElementTree as ET

import pytest

import egad
from egad.evolution import used_nodes
from egad.report.genome_drawing import NEGATIVE, POSITIVE, genome_svg

SVG = "{http://www.w3.org/2000/svg}"
GENOME = {  # a connection that skips a layer, and an unused node
    "node_keys": [0, 5, 7, 9],
    "node_biases": [0.5, 1.0, 0.0, 2.0],
    "node_activations": ["identity", "sin", "sigmoid", "gaussian"],
    "connection_sources": [-1, 5, 7, -1, -2],
    "connection_targets": [5, 7, 0, 0, 9],
    "connection_weights": [2.0, -4.0, 1.0, -0.5, 9.0],
    "connection_enabled": [True] * 5,
}


@pytest.fixture(scope="module")
def drawn():
    """Root, connections, and middles of the nodes by name."""
    root = ET.fromstring(genome_svg(GENOME))  # noqa: S314 (text that egad has made)
    middles = {}
    for group in root.findall(f"{SVG}g"):
        if "transform" in group.attrib:
            place = group.attrib["transform"].removeprefix("translate(").rstrip(")")
            middles[group.find(f"{SVG}text").text] = tuple(map(float, place.split()))
    return root, root.findall(f".//{SVG}path"), middles


def test_used_nodes_are_drawn_from_left_to_right(drawn):
    _, _, middles = drawn
    assert set(middles) == {"x", "h1", "h2", "output"}
    columns = [middles[name][0] for name in ("x", "h1", "h2", "output")]
    assert columns == sorted(set(columns))


def test_sign_and_weight_are_visible(drawn):
    _, paths, _ = drawn
    lines = {path.find(f"{SVG}title").text: path.attrib for path in paths}
    assert set(lines) == {"x to h1: 2", "h1 to h2: -4", "h2 to output: 1", "x to output: -0.5"}
    for title, line in lines.items():
        negative = ": -" in title
        assert line["stroke"] == (NEGATIVE if negative else POSITIVE)
        assert ("stroke-dasharray" in line) == negative
    by_weight = sorted(lines, key=lambda title: abs(float(title.split(": ")[1])))
    widths = [float(lines[title]["stroke-width"]) for title in by_weight]
    assert widths == sorted(set(widths))


def test_lines_run_between_nodes_and_around_others(drawn):
    _, paths, middles = drawn
    long = next(path for path in paths if path.find(f"{SVG}title").text.startswith("x to output"))
    flat = {part.split()[-1] for part in long.attrib["d"].replace("H", "C").split("C")[1:-1]}
    assert flat - {str(round(middles["h1"][1]))}
    assert long.attrib["d"].count("C") == 3


def test_every_released_genome_is_a_small_picture_within_its_frame():
    for each in list(egad.load("released"))[::100]:
        text = genome_svg(each.genome)
        assert len(text) < 6000
        assert text == genome_svg(each.genome)
        root = ET.fromstring(text)  # noqa: S314 (text that egad has made)
        nodes = used_nodes(each.genome)
        assert len(root.findall(f".//{SVG}path")) == sum(len(node.inputs) for node in nodes)
        width, height = float(root.attrib["width"]), float(root.attrib["height"])
        for group in root.findall(f"{SVG}g[@transform]"):
            x, y = map(float, group.attrib["transform"][10:-1].split())
            assert 42 <= x <= width - 42
            assert 18 <= y <= height - 18


def test_a_network_without_connections_is_its_output():
    root = ET.fromstring(  # noqa: S314
        genome_svg({**GENOME, "connection_enabled": [False] * 5})
    )
    assert not root.findall(f".//{SVG}path")
    assert [text.text for text in root.iter(f"{SVG}text")] == ["output", "identity"]
