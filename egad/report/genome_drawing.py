"""A genome as a drawing of its network: inputs on the left, the output on the right."""

from itertools import pairwise
from typing import NamedTuple

from egad.evolution import INPUT_NAMES, ExpressionNode, Row, used_nodes
from egad.report.colors import FONTS, INK, LINES, SOFT
from egad.report.page import render_template

COLUMN, LINE, MARGIN = 150, 54, 16
WIDTH, HEIGHT = 84, 36  # of a node
THICKEST = 6.0
POSITIVE, NEGATIVE = LINES[0], LINES[1]
Place = tuple[float, float]


class _Edge(NamedTuple):
    """A connection from node to node: the points that it passes through, one for each layer."""

    points: list[str]
    weight: float
    title: str


def genome_svg(genome: Row) -> str:
    """The network of a genome as an SVG picture of a few kilobytes; always the same text.

    Only nodes and connections that the output depends on are drawn. The width of a connection is
    its absolute weight; negative ones are dashed. Nodes show their activation function, and their
    bias when the mouse rests on them. Source: ours.

    Args:
        genome: As `EvolvedObject.genome`.
    """
    nodes = {node.name: node for node in used_nodes(genome)}
    edges = _edges(nodes)
    layers = _layers(nodes, edges)
    places = _places(layers)
    heaviest = max((abs(edge.weight) for edge in edges), default=1.0) or 1.0
    return render_template(
        "genome.html.j2",
        width=2 * MARGIN + WIDTH + COLUMN * (len(layers) - 1),
        height=2 * MARGIN + LINE * (max(map(len, layers)) - 1) + HEIGHT,
        node_width=WIDTH,
        node_height=HEIGHT,
        fonts=FONTS,
        ink=INK,
        soft=SOFT,
        positive=POSITIVE,
        negative=NEGATIVE,
        summary=_summary(nodes, edges),
        edges=[
            {
                "path": _path([places[point] for point in edge.points]),
                "width": round(0.8 + (THICKEST - 0.8) * abs(edge.weight) / heaviest, 1),
                "negative": edge.weight < 0,
                "title": edge.title,
            }
            for edge in edges
        ],
        nodes=[
            {"name": name, "x": places[name][0], "y": places[name][1], "node": nodes.get(name)}
            for layer in layers
            for name in layer
            if name in nodes or name in INPUT_NAMES
        ],
    )


def _depths(nodes: dict[str, ExpressionNode]) -> dict[str, int]:
    """Layer of each input and node: one to the right of all its inputs."""
    depths: dict[str, int] = dict.fromkeys(INPUT_NAMES, 0)
    for node in nodes.values():
        depths[node.name] = 1 + max((depths[name] for name, _ in node.inputs), default=0)
    return depths


def _edges(nodes: dict[str, ExpressionNode]) -> list[_Edge]:
    """All connections; one that skips layers passes through its own point in each of them."""
    depths = _depths(nodes)
    edges = []
    for node in nodes.values():
        for source, weight in node.inputs:
            skipped = range(depths[source] + 1, depths[node.name])
            between = [f"{source} {node.name} {layer}" for layer in skipped]
            title = f"{source} to {node.name}: {weight:.3g}"
            edges.append(_Edge([source, *between, node.name], weight, title))
    return edges


def _layers(nodes: dict[str, ExpressionNode], edges: list[_Edge]) -> list[list[str]]:
    """Nodes and points of each layer, from the top, sorted by the mean position of their inputs."""
    entering: dict[str, list[str]] = {name: [] for name in nodes}
    used = set()
    for edge in edges:
        used.add(edge.points[0])
        for before, after in pairwise(edge.points):
            entering.setdefault(after, []).append(before)
    depths = _depths(nodes)
    layers = [[name for name in INPUT_NAMES if name in used]]
    for depth in range(1, 1 + depths["output"]):
        above = {name: row for row, name in enumerate(layers[-1])}
        names = [name for name in entering if _depth(name, depths) == depth]
        means = {name: _mean([above[each] for each in entering[name]]) for name in names}
        layers.append(sorted(names, key=means.__getitem__))
    return layers


def _depth(name: str, depths: dict[str, int]) -> int:
    """Layer of a node, or of a point of a connection, whose name ends with the layer."""
    return depths[name] if name in depths else int(name.rsplit(" ", 1)[1])


def _mean(values: list[int]) -> float:
    return sum(values) / len(values) if values else 0.0


def _places(layers: list[list[str]]) -> dict[str, Place]:
    """Center of each node and point; layers are centered on each other."""
    tallest = max(map(len, layers))
    return {
        name: (
            MARGIN + WIDTH / 2 + COLUMN * column,
            MARGIN + HEIGHT / 2 + LINE * (row + (tallest - len(layer)) / 2),
        )
        for column, layer in enumerate(layers)
        for row, name in enumerate(layer)
    }


def _path(places: list[Place]) -> str:
    """A smooth curve from the right side of the first node to the left side of the last one."""
    (x, y), *others = places
    x, path = x + WIDTH / 2, f"M{x + WIDTH / 2:g} {y:g}"
    for number, (after, below) in enumerate(others, 1):
        end = after - WIDTH / 2
        path += f"C{(x + end) / 2:g} {y:g} {(x + end) / 2:g} {below:g} {end:g} {below:g}"
        x, y = after + WIDTH / 2, below
        if number < len(others):
            path += f"H{x:g}"
    return path


def _summary(nodes: dict[str, ExpressionNode], edges: list[_Edge]) -> str:
    hidden = len(nodes) - 1
    return f"Network with {hidden} hidden nodes and {len(edges)} connections"
