"""Distances to many sources, lowered side by side with wide instructions.

The compiler does not keep a row of an array in registers while others are compared with it, as it
cannot know that they are different rows. So the few instructions for that are written out here.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numba.core.base import BaseContext
from numba.core.types import Type
from numba.core.typing.context import Context
from numba.core.typing.templates import Signature
from numba.extending import intrinsic
from numpy.typing import NDArray

from egad._util.kernels import kernel

_WIDE, _COUNT = 4, 13  # numbers in a register; registers: most processors have 16 that wide
LANES = _WIDE * _COUNT  # sources of a row

_INDEX, _FLAGS = ir.IntType(64), ir.IntType(_WIDE)
_VECTOR = ir.VectorType(ir.DoubleType(), _WIDE)


def _typed(
    _typing: Context,
    distances: Type,
    vertex: Type,
    neighbors: Type,
    lengths: Type,
    start: Type,
    end: Type,
) -> tuple[Signature, object]:
    return numba.boolean(distances, vertex, neighbors, lengths, start, end), _generate


def _generate(
    context: BaseContext, builder: ir.IRBuilder, signature: Signature, arguments: list[ir.Value]
) -> ir.Value:
    rows, neighbors, lengths = (
        context.make_array(signature.args[i])(context, builder, arguments[i]).data
        for i in (0, 2, 3)
    )
    own = _row(builder, rows, arguments[1])
    least = [cgutils.alloca_once_value(builder, builder.load(place, align=8)) for place in own]
    with cgutils.for_range(builder, arguments[5], arguments[4], intp=_INDEX) as loop:
        neighbor = builder.zext(builder.load(builder.gep(neighbors, [loop.index])), _INDEX)
        length = _spread(builder, builder.load(builder.gep(lengths, [loop.index])))
        for place, best in zip(_row(builder, rows, neighbor), least, strict=True):
            distance = builder.fadd(builder.load(place, align=8), length)
            nearer = builder.fcmp_ordered("<", distance, builder.load(best))
            builder.store(builder.select(nearer, distance, builder.load(best)), best)
    lowered = ir.Constant(ir.VectorType(ir.IntType(1), _WIDE), None)
    for place, best in zip(own, least, strict=True):
        nearer = builder.fcmp_ordered("<", builder.load(best), builder.load(place, align=8))
        lowered = builder.or_(lowered, nearer)
        builder.store(builder.load(best), place, align=8)
    return builder.icmp_unsigned("!=", builder.bitcast(lowered, _FLAGS), ir.Constant(_FLAGS, 0))


def _row(builder: ir.IRBuilder, rows: ir.Value, vertex: ir.Value) -> list[ir.Value]:
    """Where the parts of a row are."""
    first = builder.gep(rows, [builder.mul(vertex, ir.Constant(_INDEX, LANES))])
    first = builder.bitcast(first, _VECTOR.as_pointer())
    return [builder.gep(first, [ir.Constant(_INDEX, i)]) for i in range(_COUNT)]


def _spread(builder: ir.IRBuilder, number: ir.Value) -> ir.Value:
    """A number in every place of a vector."""
    undefined, indices = ir.Constant(_VECTOR, ir.Undefined), ir.VectorType(ir.IntType(32), _WIDE)
    single = builder.insert_element(undefined, number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(single, undefined, ir.Constant(indices, None))


_lower: Any = intrinsic(_typed)


@kernel(inline="always")
def lower(
    distances: NDArray[np.float64],
    vertex: int,
    neighbors: NDArray[np.uint32],
    lengths: NDArray[np.float64],
    start: int,
    end: int,
) -> bool:
    """Lower the distances of a vertex to those by way of some neighbors; says if any was lowered.

    Args:
        distances: (n, LANES), in one piece.
        vertex: Whose.
        neighbors: (e,).
        lengths: (e,) of the edges to them.
        start: First of these edges that counts.
        end: The one after the last.
    """
    lowered: bool = _lower(distances, vertex, neighbors, lengths, start, end)
    return lowered
