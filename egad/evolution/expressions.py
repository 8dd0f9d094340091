"""Genomes as text: one readable expression for each node of the network (ours)."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from egad.evolution.constraints import AXES, across
from egad.evolution.genome import OUTPUT, Row
from egad.evolution.parameters import Region, Shape, Symmetry
from egad.evolution.query import NO_SYMMETRY, evaluation_order, query

INPUT_NAMES = ("x", "y", "z", "r_xy", "r_xz", "r_yz", "r")
_DISTANCES = {
    "r_xy": "r_xy = sqrt(x**2 + y**2)",
    "r_xz": "r_xz = sqrt(x**2 + z**2)",
    "r_yz": "r_yz = sqrt(y**2 + z**2)",
    "r": "r = sqrt(x**2 + y**2 + z**2)",
}
_FUNCTIONS = {"sigmoid": "1 / (1 + exp(-5*a))", "gaussian": "exp(-5 * a**2)", "identity": "a"}
_REGIONS = {
    "envelope": "solid voxels lie inside it",
    "keep_solid": "it is solid",
    "hole": "it is empty",
}
_THEN = "# Then hidden holes are filled, thin parts are removed, and the largest body is kept."
EXACT = 17  # digits that give back the same number


class ExpressionNode(NamedTuple):
    """A node that the output of a network depends on."""

    name: str  # `h1`, `h2` and so on in the order of evaluation; the last one is `output`
    activation: str
    bias: float  # added to the weighted inputs
    # name and weight of each input: another node, or one of `INPUT_NAMES`
    inputs: tuple[tuple[str, float], ...]


def used_nodes(genome: Row) -> list[ExpressionNode]:
    """The nodes that the output of a network depends on, in the order of evaluation."""
    place = {int(key): number for number, key in enumerate(genome["node_keys"])}
    names = {-1 - number: name for number, name in enumerate(INPUT_NAMES)}
    nodes = []
    for number, (key, links) in enumerate(evaluation_order(genome), 1):
        names[key] = "output" if key == OUTPUT else f"h{number}"
        inputs = tuple((names[source], weight) for source, weight in links)
        bias = float(genome["node_biases"][place[key]])
        activation = str(genome["node_activations"][place[key]])
        nodes.append(ExpressionNode(names[key], activation, bias, inputs))
    return nodes


def genome_text(
    genome: Row,
    *,
    digits: int | None = None,
    shape: Shape | None = None,
    symmetry: Symmetry = NO_SYMMETRY,
    regions: Mapping[str, Region] | None = None,
) -> str:
    """A genome as expressions, one line for each node that its shape depends on.

    The text is Python for numbers or NumPy arrays `x`, `y` and `z`, given `sqrt`, `exp`, `sin` and
    the activation functions that its comments define. Source: ours.

    Args:
        genome: As `EvolvedObject.genome`.
        digits: Significant digits of weights and biases; None: the fewest that leave all voxels as
            they are, at the resolution of the shape; 17 are exact.
        shape: Threshold and resolution; those of the released objects by default.
        symmetry: Symmetry that the shape was evolved with.
        regions: The other constraints by the names of their sections: `envelope`, `keep_solid`,
            `hole`.
    """
    shape = shape or Shape()
    if digits is None:
        digits = enough_digits(genome, shape, symmetry)
    nodes = used_nodes(genome)
    inputs = {name for node in nodes for name, _ in node.inputs}
    lines = ["# x, y, z run from -1 to 1 over the cube.", *_symmetry_lines(symmetry)]
    lines += [line for name, line in _DISTANCES.items() if name in inputs]
    used = {node.activation for node in nodes}
    lines += [f"# {name}(a) = {text}" for name, text in _FUNCTIONS.items() if name in used]
    lines += [f"{node.name} = {_expression(node, digits)}" for node in nodes]
    lines.append(f"solid = output > {shape.threshold:g}")
    lines += [
        f"# {name}: {_where(region)}; {_REGIONS[name]}."
        for name, region in (regions or {}).items()
        if region.kind != "none"
    ]
    return "\n".join([*lines, _THEN]) + "\n"


def enough_digits(genome: Row, shape: Shape, symmetry: Symmetry = NO_SYMMETRY) -> int:
    """The fewest significant digits of weights and biases that change no voxel, 2 to 17."""
    expected = query(genome, shape.resolution, symmetry) > shape.threshold
    for digits in range(2, EXACT):
        names = ("node_biases", "connection_weights")
        rounded = {name: [float(_number(each, digits)) for each in genome[name]] for name in names}
        output = query({**genome, **rounded}, shape.resolution, symmetry)
        if np.array_equal(output > shape.threshold, expected):
            return digits
    return EXACT


def _number(value: float, digits: int) -> str:
    return repr(float(value)) if digits >= EXACT else f"{value:.{digits}g}"


def _expression(node: ExpressionNode, digits: int) -> str:
    """The value of a node, such as `sin(1.5*x - 0.2*h1 + 0.7)`."""
    terms = [(weight, f"*{name}") for name, weight in node.inputs]
    if node.bias or not terms:
        terms.append((node.bias, ""))
    text = ""
    for value, factor in terms:
        number = f"{_number(abs(value), digits)}{factor}"
        sign = "-" if value < 0 else "+"
        text += f" {sign} {number}" if text else f"{sign.strip('+')}{number}"
    return f"{node.activation}({text})"


def _symmetry_lines(symmetry: Symmetry) -> list[str]:
    """What `constraints.folded` does to the coordinates, as Python."""
    lines = [f"{axis} = abs({axis})" for axis in symmetry.mirror]
    if symmetry.fold > 1:
        a, b = (AXES[place] for place in across(symmetry.axis))
        lines += [
            f"radius, angle = sqrt({a}**2 + {b}**2), {symmetry.fold}*arctan2({b}, {a})",
            f"{a}, {b} = radius*cos(angle), radius*sin(angle)",
        ]
        for axis in (a, b):
            if axis in symmetry.mirror:
                kept = a if axis == a and symmetry.fold % 2 else b
                lines.append(f"{kept} = abs({kept})")
    return lines


def _where(region: Region) -> str:
    """A region in words; lengths are fractions of the sides of the cube."""
    size = ", ".join(f"{side:g}" for side in region.size)
    center = ", ".join(f"{each:g}" for each in region.center)
    kind = {"mesh": f"mesh {region.mesh}", "cylinder": f"cylinder along {region.axis}"}
    return f"{kind.get(region.kind, region.kind)}, sides ({size}) of the cube, center ({center})"
